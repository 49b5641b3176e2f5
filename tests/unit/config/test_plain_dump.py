"""Plain data that is written and read again is what it was, texts like numbers included."""

import random

import pytest

from rig.config.plain_dump import dump_plain
from rig.config.yaml_loader import read_plain

TEXTS = (
    "178e9576", "1e5", "00000001", "12345678", "0x1f", "1_000", ".5", "5.", "-3", "+7", "e12",
    "2026-11-24", "true", "null", "~", "yes", "", " ", "a: b", "# no", "ünï", ".inf", "0.015 m",
)  # fmt: skip


def again(tmp_path, content):
    path = tmp_path / "content.yaml"
    path.write_text(dump_plain(content), encoding="utf-8")
    return read_plain(path)


@pytest.mark.parametrize("text", TEXTS)
def test_a_text_stays_the_text_that_it_was(tmp_path, text):
    assert again(tmp_path, {"digest": text, "all": [text]}) == {"digest": text, "all": [text]}


def test_drawn_digests_stay_texts(tmp_path):
    chance = random.Random(9576)
    drawn = {f"k{k}": "".join(chance.choices("0123456789e", k=8)) for k in range(2000)}
    assert again(tmp_path, drawn) == drawn


def test_quantities_are_not_quoted():
    assert dump_plain({"length": "0.015 m", "gain": 0.5}) == "length: 0.015 m\ngain: 0.5\n"
