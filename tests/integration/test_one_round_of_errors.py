"""What is wrong with files and options is told in one round, each with its file and line."""

import re

import pytest

from rig.cli import invoke

PROFILE = """\
extends: cylinder
lop: {rate: 400 Hz}
loop:
  rate: 500 kg
  max_missed: 5000
devices:
  regulators:
    eds: nothere.eds
  encoder-agonist:
    bus: canx
simulation:
  seed: x
  faults: [{at: 5 s, device: nobody, fault: silent}]
"""
EXPERIMENT = """\
name: bad
rig: {rig}
controller: cascad
reference:
  kind: sine
  amplitude: 10 kg
  tones: [{{frequency: 0.25 Hz, periods: 0}}]
approach: -3 s
metrics:
  tracking_rmss: {{max: 0.9 mm}}
  late: {{measure: latenes, max: 1}}
  tracking_max: {{max: 9 mm}}
figures: [trackin, tracking]
extra: 3
"""
IN_PROFILE = {2, 4, 5, 8, 10, 12, 13}
IN_EXPERIMENT = {3, 6, 7, 8, 10, 11, 13, 14}


@pytest.fixture
def lines(tmp_path, monkeypatch, capsys):
    """Return what says the lines of each file that a command tells, and what it said."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rig.yaml").write_text(PROFILE)

    def told(*words, rig="rig.yaml"):
        (tmp_path / "exp.yaml").write_text(EXPERIMENT.format(rig=rig))
        assert invoke([*words]) == 2
        said = capsys.readouterr().err
        found = re.findall(r"^(?:error: )?(rig|exp)\.yaml:(\d+):\d+: ", said, re.MULTILINE)
        return {of: {int(n) for f, n in found if f == of} for of in ("rig", "exp")}, said

    return told


def test_a_profile_is_told_whole(lines):
    found, _ = lines("check", "rig.yaml")
    assert found == {"rig": IN_PROFILE, "exp": set()}


@pytest.mark.parametrize("rig", ["rig.yaml", "cylinder"])
def test_an_experiment_is_told_with_its_profile_and_its_names(lines, rig):
    found, said = lines("check", "exp.yaml", rig=rig)
    assert found["exp"] == IN_EXPERIMENT
    assert found["rig"] == (IN_PROFILE if rig == "rig.yaml" else set())
    assert "did you mean tracking_rms?" in said
    assert "did you mean tracking?" in said


def test_options_are_told_with_the_rest(lines):
    options = ("--set", "loop.rate=3 kg", "--set", "controller=casc")
    _, said = lines("run", "cylinder-sine", *options)
    assert "loop.rate: '3 kg' is not in Hz" in said
    assert "no controller is called 'casc'" in said
    _, said = lines("run", "cylinder-sine", "--set", "foo=1", "--set", "lop.rate=2")
    assert "--set foo=1: there is no key 'foo'" in said
    assert "--set lop.rate=2: there is no key 'lop'; did you mean 'loop'?" in said


LATER = {
    "numbers": (
        "  encoder-agonist: {node: 5}\n  encoder-antagonist: {node: 5}\n",
        "devices.encoder-agonist and devices.encoder-antagonist both have number 0x05",
    ),
    "bore": ("cylinder: {bore: 32 mm}\n", "plant.cylinder.bore is 16 mm"),
    "range": ("cylinder: {limits: {pressure: [0 kPa, 900 kPa]}}\n", "exceeds what regulators can"),
    "encoder": ("cylinder: {stroke: 61 mm}\n", "encoder-agonist: its stroke 0.06 m is shorter"),
}
EARLIER = {
    "a gain": (
        "controllers: {pid: {proportional: 3 kg}}\n",
        "controllers.pid|proportional: '3 kg'",
    ),
    "a fault": ("simulation: {seed: x}\n", "seed is 'x'"),
    "a key": ("lop: 3\n", "unknown key 'lop'"),
}


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize("early", EARLIER)
@pytest.mark.parametrize("late", LATER)
def test_what_parts_say_of_each_other_is_told_beside_what_cannot_be_read(
    tmp_path, monkeypatch, capsys, early, late, command
):
    if early == "a key" and late in ("range", "encoder"):
        pytest.skip("without the head of a profile no device is made")
    monkeypatch.chdir(tmp_path)
    wrong, said = EARLIER[early]
    text, told = LATER[late]
    devices = f"devices:\n{text}" if late == "numbers" else text
    (tmp_path / "rig.yaml").write_text(f"extends: cylinder\nname: rig\n{wrong}{devices}")
    words = ["check", "rig.yaml"]
    if command == "run":
        words = ["run", "cylinder-sine", "--on", "sim", "--rig", "rig.yaml"]
    assert invoke(words) == 2
    err = capsys.readouterr().err
    assert told in err and re.search(said, err), err
    assert re.search(r"^\d+ errors$", err, re.MULTILINE)


def test_no_device_is_missed_that_cannot_be_read(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = "devices:\n  encoder-agonist: {node: x}\ncontrollers: {pid: {proportional: 3 kg}}\n"
    (tmp_path / "rig.yaml").write_text(f"extends: cylinder\nname: rig\n{text}")
    assert invoke(["check", "rig.yaml"]) == 2
    err = capsys.readouterr().err
    assert err.count("2 errors") == 1 and "no device" not in err, err
