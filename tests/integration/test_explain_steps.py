"""`rig explain` of a failed step of an acceptance test, and of messages about files."""

import pytest

from rig.cli import invoke
from rig.explaining.faults import refusal_of
from rig.explaining.refused_run import step_topic


def test_a_failed_step_is_what_is_explained(tmp_path, monkeypatch, capsys):
    (tmp_path / "configs" / "rigs").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    swapped = "devices.regulators.stop_active_low=false"
    assert invoke(["commission", "cylinder", "--set", swapped]) == 3
    capsys.readouterr()
    assert invoke(["explain"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("stopped: `rig commission cylinder --on virtual`: exit code 3")
    for label in ("message: emergency-stop: ", "causes: ", "check: ", "mend: "):
        assert label in said


@pytest.mark.parametrize(
    ("message", "kind"),
    [
        ("actuators: agonist: tubes swapped: its regulator is right, and …", "swapped"),
        ("actuators: regulators: setpoint of agonist is 8 kPa, outside 11.35 … 885.9 kPa",
         "step_setpoint"),
        ("response: agonist: sticky or slow valve; dead time: 40 ms", "failed_step"),
    ],
)  # fmt: skip
def test_a_step_has_its_kind(message, kind):
    assert step_topic(message).name == kind


@pytest.mark.parametrize(
    ("message", "kind"),
    [
        ("s_dup.yaml:56:3: rod is here twice; first in line 55", "unknown_key"),
        ("devices.a and devices.b both have number 0x22 on the bus can0", "same_number"),
        ("tab.yaml:3:1: a tab has no place in this file; use spaces", "unreadable"),
        ("b.yaml:1:10: extends: a.yaml extends this file in turn", "extends_itself"),
    ],
)
def test_what_is_wrong_with_a_file_has_its_kind(message, kind):
    assert refusal_of(message).name == kind


def test_a_run_that_is_none_is_called_so(tmp_path, monkeypatch, capsys):
    (tmp_path / "runs").mkdir()
    monkeypatch.chdir(tmp_path)
    assert invoke(["explain", "runs/none"]) == 2
    assert "there is no run runs/none" in capsys.readouterr().err
