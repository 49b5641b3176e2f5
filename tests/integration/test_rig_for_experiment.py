"""A rig where an experiment belongs, a plant of another size: each is a sentence, before a run."""

import json
import re

import pytest

from rig.cli.commands import invoke
from rig.runtime.log import read_log


@pytest.fixture(autouse=True)
def ours(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ours.yaml").write_text("extends: cylinder\ndescription: ours\n")


def test_a_rig_is_no_experiment(capsys):
    assert invoke(["run", "ours.yaml"]) == 2
    assert "ours.yaml is a rig" in capsys.readouterr().err


def test_faults_are_tried_on_another_rig(capsys):
    assert invoke(["faults", "run", "ours.yaml", "--only", "emergency_stop"]) == 0
    assert "ours" in capsys.readouterr().out


def test_an_experiment_is_checked_on_another_rig(capsys):
    assert invoke(["check", "cylinder-step", "--rig", "ours.yaml"]) == 0
    assert "ours" in capsys.readouterr().out
    assert invoke(["check", "ours.yaml", "--rig", "cylinder"]) == 2


@pytest.mark.parametrize(("bound", "code"), [("1 us", 1), ("1 s", 0)])
def test_bounds_that_are_missed_on_another_rig_are_told_to_be_for_the_experiments_own(
    capsys, bound, code
):
    args = ["run", "cylinder-step", "--on", "sim", "--no-report", "--rig", "ours.yaml"]
    assert invoke([*args, "--set", f"metrics.rise_time.max={bound}"]) == code
    told = "with --rig ours.yaml the bounds stay those that cylinder-step has for the rig it names"
    assert (told in capsys.readouterr().err) is (code == 1)


@pytest.mark.parametrize(
    ("believed", "true", "said"),
    [
        ("{stroke: 100 mm}", "", ("cylinder.stroke: ours.yaml:3:12", "by default")),
        ("{home: 36 mm}", "", ("cylinder.home: ours.yaml:3:12",)),
        ("{}", "plant: {home: 36 mm}", ("plant.home: ours.yaml:4:9", "cylinder.home: ")),
        ("{}", "plant: {cylinder: {stroke: 90 mm}}", ("plant.cylinder.stroke: ours.yaml:4:20",)),
    ],
)
def test_a_plant_of_another_size_is_refused_with_both_places(
    tmp_path, capsys, believed, true, said
):
    encoders = "".join(
        f"  encoder-{side}: {{stroke: 100 mm}}\n" for side in ("agonist", "antagonist")
    )
    text = (
        f"extends: cylinder\ndescription: ours\ncylinder: {believed}\n{true}\ndevices:\n{encoders}"
    )
    (tmp_path / "ours.yaml").write_text(text)
    assert invoke(["check", "ours.yaml"]) == 2
    err = capsys.readouterr().err
    for words in said:
        assert words in err


def test_what_homing_leaves_is_borne(tmp_path):
    (tmp_path / "ours.yaml").write_text("extends: cylinder\nplant: {home: 29 mm}\n")
    assert invoke(["check", "ours.yaml"]) == 0


LINE = "devices.regulators.channels.agonist.setpoint"


@pytest.mark.parametrize("raw", ["", ", raw: [0, 32767]"])
def test_counts_of_another_signal_are_refused_with_both_places(tmp_path, capsys, raw):
    (tmp_path / "ours.yaml").write_text(
        "extends: cylinder\ndevices:\n  regulators:\n    channels:\n      agonist:\n"
        f"        setpoint: {{voltage: null, current: [4 mA, 20 mA]{raw}}}\n"
    )
    assert invoke(["check", "ours.yaml"]) == (0 if raw else 2)
    err = capsys.readouterr().err
    assert raw or f"{LINE}.current: ours.yaml:6:35" in err
    assert raw or (f"{LINE}.raw: " in err and "cylinder.yaml:27:" in err)


CURRENT = (
    "devices:\n  regulators:\n    channels:\n      agonist:\n"
    "        setpoint: {voltage: null, current: [4 mA, 20 mA]"
)
COUNTS = "devices: {regulators: {channels: {agonist: {setpoint: {raw: [6554, 32767]}}}}}\n"


def test_counts_alone_may_be_others_of_a_signal_that_stays(tmp_path, capsys):
    (tmp_path / "ours.yaml").write_text(f"extends: cylinder\n{CURRENT}, raw: [0, 32767]}}\n")
    option = ["--set", f"{LINE}.raw=[6554,32767]"]
    assert invoke(["check", "ours.yaml", *option]) == 0
    (tmp_path / "child.yaml").write_text(f"extends: ours.yaml\n{COUNTS}")
    assert invoke(["check", "child.yaml"]) == 0
    signal = ["--set", f"{LINE}.voltage=null", "--set", f"{LINE}.current=[4 mA, 20 mA]"]
    assert invoke(["check", "cylinder", *signal, *option]) == 0
    capsys.readouterr()
    assert invoke(["check", "cylinder", *signal]) == 2
    assert f"{LINE}.raw was said of another signal" in capsys.readouterr().err


def test_counts_below_the_file_that_changes_the_signal_are_refused(tmp_path, capsys):
    (tmp_path / "counts.yaml").write_text(f"extends: cylinder\n{COUNTS}")
    (tmp_path / "ours.yaml").write_text(f"extends: counts.yaml\n{CURRENT}}}\n")
    assert invoke(["check", "ours.yaml"]) == 2
    assert f"{LINE}.raw: counts.yaml:2:" in capsys.readouterr().err


def test_a_fault_is_told_with_both_clocks_and_its_stretch(tmp_path, capsys):
    words = [
        "run", "cylinder-ideal-step", "--on", "sim", "--no-report", "--out", "runs",
        "--set", "cylinder.limits.position=[-20 mm, 4 mm]", "--set", "reference.size=3.9 mm",
        "--set", "cylinder.limits.speed=3 mm/s",
    ]  # fmt: skip
    assert invoke(words) == 4
    (folder,) = (tmp_path / "runs").iterdir()
    (line,) = (x for x in capsys.readouterr().err.splitlines() if x.startswith("when: "))
    log = read_log(folder / "log.mcap")
    clock, reference = log.column("clock")[-1], log.column("reference.time")[-1]
    seen = [float(number) for number in re.findall(r"(\d+\.\d{3}) s", line)]
    assert seen == pytest.approx([clock, reference], abs=2e-3)
    segments = json.loads((folder / "evaluation.json").read_text())["segments"]
    (name,) = (s["name"] for s in segments if s["start"] <= reference < s["end"])
    assert repr(name) in line
    assert invoke(["explain", str(folder)]) == 0
    assert " ".join(capsys.readouterr().out.split()).count(line) == 1
