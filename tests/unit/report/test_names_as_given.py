"""Advice on a run names files as they were given, so that the command can be typed."""

from rig.explaining.ended_run import as_given


def test_a_file_is_named_by_its_path():
    command = ["rig", "run", "lab/mytrack.yaml", "--on", "sim", "--rig", "lab/mine.yaml"]
    assert as_given("mine", "mytrack", command) == {
        "RIG": "lab/mine.yaml", "EXPERIMENT": "lab/mytrack.yaml",
    }  # fmt: skip


def test_a_name_stays_a_name():
    command = ["rig", "run", "cylinder-sine", "--rig", "cylinder-low-speed"]
    assert as_given("cylinder-low-speed", "cylinder-sine", command) == {
        "RIG": "cylinder-low-speed", "EXPERIMENT": "cylinder-sine",
    }  # fmt: skip
    assert as_given("mine", "x", ["python", "a.yaml"])["RIG"] == "mine"
