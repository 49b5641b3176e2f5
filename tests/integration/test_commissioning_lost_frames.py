"""A bus that loses frames does not pass the acceptance test, whichever of them are lost."""

import random

import pytest

from rig.cli import invoke
from rig.commissioning.lost_frames import BRIEFLY, MOST, lost_frames

TELL = ("lost", "held_samples", "lost_setpoints", "missed", "damaged")


@pytest.mark.parametrize("seed", range(10))
def test_each_frame_that_is_told_of_counts_once(seed):
    chance = random.Random(seed)
    counts = {name: chance.randrange(5) for name in chance.sample(TELL, 3)}
    counts["omitted_syncs"] = chance.randrange(4)
    lost = sum(counts[name] for name in TELL if name in counts) + max(
        counts["omitted_syncs"] - 1, 0
    )
    size = chance.choice([1, 16])
    unit = {1: "frames", 16: "bytes"}[size]
    counts |= {f"{unit}_in": size * 700, f"{unit}_out": size * 300, "late": 9, "unknown": 9}
    value = lost_frames(" now", "can7", counts, 0.0)
    assert value.value == pytest.approx(lost / 1000)
    assert value.name == "share of the frames on can7 that are lost now"


def test_a_bus_that_carries_nothing_has_lost_what_it_says():
    assert lost_frames("", "can0", {"lost": 3.0}, BRIEFLY).value == 3.0


@pytest.mark.parametrize("share", [2 * MOST, 10 * MOST])
def test_lost_frames_are_found(tmp_path, monkeypatch, capsys, share):
    (tmp_path / "lossy.yaml").write_text(
        "extends: cylinder\nsimulation: {faults: "
        f"[{{at: 0 s, device: can0, fault: frame_loss, value: {share}}}]}}\n"
    )
    monkeypatch.chdir(tmp_path)
    assert invoke(["commission", "lossy.yaml"]) == 3
    said = "".join(capsys.readouterr())
    assert "FAILED: can0: frames are lost under control" in said.replace("\n", " ")
