"""`rig reset RIG --on sim|virtual` rehearses what resets a rig on hardware, and resets nothing."""

import json
from pathlib import Path

import pytest

from rig.cli import invoke
from rig.experiment.fault_latch import FaultLatch


@pytest.fixture(autouse=True)
def latch(tmp_path, monkeypatch):
    """A fault of the real rig, which no rehearsal may touch."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    kept = FaultLatch("cylinder")
    kept.set(Path("runs/1"), "it fell")
    return kept


@pytest.mark.parametrize("on", ["sim", "virtual"])
@pytest.mark.parametrize("rig", ["cylinder", "legs-can"])
def test_simulated_hands_press_and_release(on, rig, latch, capsys):
    assert invoke(["reset", rig, "--on", on]) == 0
    assert f"a rehearsal on {on}: on hardware this resets {rig}" in capsys.readouterr().err
    assert latch.reason() is not None


@pytest.mark.parametrize("on", ["sim", "virtual"])
@pytest.mark.parametrize(
    ("faults", "code", "told"),
    [
        (((1.0, 1),), 3, "it is pressed, and nobody has released it"),
        (((0.0, 1),), 3, "it is pressed, and nobody has released it"),
        (((0.3, 1), (0.9, 0)), 0, "it stays latched"),
        (((0.3, 0),), 3, "its circuit was closed all the time"),
    ],
    ids=["never released", "pressed all the time", "both", "never pressed"],
)
def test_the_faults_of_a_profile_press_in_their_place(on, faults, code, told, latch, capsys):
    said = ", ".join(
        f"{{at: {at}, device: regulators, fault: emergency_stop, value: {value}}}"
        for at, value in faults
    )
    words = ["reset", "cylinder", "--on", on, "--wait", "3"]
    assert invoke([*words, "--set", f"simulation.faults=[{said}]", "--json"]) == code
    shown = capsys.readouterr()
    assert told in shown.err
    found = json.loads(shown.out)
    assert found["rehearsed"] is (code == 0)
    assert found["is_latched"]
    assert latch.reason() is not None


@pytest.mark.parametrize(("yes", "code"), [("legs", 0), ("arm", 2)])
def test_a_rig_without_a_contact_asks_for_its_name_here_too(yes, code):
    assert invoke(["reset", "legs", "--on", "virtual", "--yes", yes]) == code
