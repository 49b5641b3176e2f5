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
