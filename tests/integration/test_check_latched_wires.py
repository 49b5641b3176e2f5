"""A fault that one profile has latched is told by `rig check` of another one on the same wires."""

from pathlib import Path

import pytest

import rig
from rig.assembly import REGISTRY
from rig.cli.commands import invoke
from rig.config import load_profile
from rig.experiment.fault_latch import FaultLatch

CONFIGS = Path(rig.__file__).parents[1] / "configs"


@pytest.mark.parametrize("of_an_experiment", [False, True])
def test_a_copy_of_a_latched_profile_is_told_of_the_fault(
    tmp_path, capsys, monkeypatch, of_an_experiment
):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    copy = tmp_path / "copy.yaml"
    copy.write_text("extends: cylinder\n")
    what = ("cylinder-sine", "--rig", str(copy)) if of_an_experiment else (str(copy),)
    words = ["check", *what, "--configs", str(CONFIGS)]
    assert invoke(words) == 0
    assert "is latched" not in capsys.readouterr().err
    latch = FaultLatch.of(load_profile("cylinder", REGISTRY, (), [CONFIGS]))
    latch.set(tmp_path / "run", "the supply pressure is lost")
    assert invoke(words) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "hardware would refuse it: copy: cylinder is on" in told
    assert "its last fault is latched: the supply pressure is lost" in told
    latch.clear()
    assert invoke(words) == 0
    assert "is latched" not in capsys.readouterr().err
