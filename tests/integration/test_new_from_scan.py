"""`rig new rig --scan`: a rig whose numbers nobody wrote down, over real sockets."""

import random
import subprocess
import sys
from contextlib import contextmanager

import pytest

from rig.cli import invoke

GROUPS = {"cylinder": ["239.74.163.41"], "joint": ["239.74.163.42", "239.74.163.43"]}
NODES = {
    "cylinder": ["regulators.node", "encoder-agonist.node", "encoder-antagonist.node"],
    "joint": ["regulators.node", *(f"encoder-{k}.node" for k in (1, 2, 3, 4))],
}


@contextmanager
def emulated(rig, on, *settings):
    words = [word for setting in settings for word in ("--set", setting)]
    process = subprocess.Popen(
        [sys.executable, "-m", "rig", "simulate", rig, "--on", on, *words],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert any("Ctrl-C" in line for line in process.stderr), "it has not begun"
        yield
    finally:
        process.terminate()
        process.communicate()


@pytest.mark.parametrize("rig", GROUPS)
def test_a_rig_is_written_from_what_answers(tmp_path, monkeypatch, capfd, rig):
    monkeypatch.chdir(tmp_path)
    on = ",".join(f"udp_multicast:{group}" for group in GROUPS[rig])
    # Rising, so that the order of encoders is the one that a scan can know.
    numbers = sorted(random.Random(rig).sample(range(1, 128), len(NODES[rig])))
    settings = [f"devices.{key}={number}" for key, number in zip(NODES[rig], numbers, strict=True)]
    with emulated(rig, on, *settings):
        assert invoke(["new", "rig", "mine", "--like", rig, "--scan", on]) == 0
        assert "mine is written" in capfd.readouterr().err
        assert invoke(["check", "mine.yaml", "--on", on]) == 0
        assert f"{len(numbers)} of {len(numbers)} nodes are as the profile says" in (
            capfd.readouterr().err
        )
    assert invoke(["check", "mine.yaml"]) == 0
    text = (tmp_path / "mine.yaml").read_text()
    for number in numbers:
        assert f"    node: 0x{number:02X} " in text


def test_where_nobody_answers_nothing_is_written(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert invoke(["new", "rig", "mine", "--scan", "udp_multicast:239.74.163.44"]) == 3
    assert "nobody answers there" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["experiment", "mine", "--scan", "can0"], "--scan is for a rig"),
        (["rig", "mine", "--scan", "sim"], "no bus that could be asked"),
        (["rig", "mine", "--scan", "nothing0"], "nothing0"),
        (["rig", "mine", "--like", "legs", "--scan", "can0"], "has no CAN bus"),
    ],
)
def test_what_cannot_be_scanned_is_refused(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    assert invoke(["new", *words]) in (2, 3)
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
