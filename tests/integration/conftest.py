"""What whole runs share."""

import dataclasses
import shutil
from pathlib import Path

import pytest
import warm_start
from broken_package import plug_in

from rig.assembly import Backend, build_rig
from rig.assembly.simulated import build_virtual
from rig.commissioning.record import CommissioningState
from rig.experiment import frozen

__all__ = ["plug_in"]
CONFIGS = Path(__file__).parents[2] / "configs"
_FREEZES = {}


@pytest.fixture(autouse=True)
def _remembered_freezes(monkeypatch):
    """Try a plan's frozen setpoints on the plant once: every run on hardware asks for the same.

    It takes a second and more, and `closed_loop/test_frozen_setpoints.py` has no part in this.
    """
    longest_freeze = frozen.longest_freeze

    def remembered(plan, say=lambda _: None):
        simulation = dataclasses.replace(plan.profile.simulation, faults=())
        profile = dataclasses.replace(plan.profile, simulation=simulation, files=())
        experiment = dataclasses.replace(plan.experiment, files=())
        key = repr((profile, experiment))
        if key not in _FREEZES:
            _FREEZES[key] = longest_freeze(plan, say)
        return _FREEZES[key]

    monkeypatch.setattr(frozen, "longest_freeze", remembered)


@pytest.fixture(autouse=True)
def _commissioned(request, monkeypatch):
    """Take every rig for a commissioned one, but in the modules that say that they commission."""
    if not getattr(request.module, "COMMISSIONS", False):
        passed = CommissioningState("", "")
        monkeypatch.setattr("rig.commissioning.permission.verdict_of", lambda *_: passed)


@pytest.fixture
def warm_workers(monkeypatch):
    """Fork the servers of workers, which import all that a run might, from one that has.

    How Python starts them is seen where a sweep has a process of its own (`test_sweep_kills.py`).
    """
    program = "import os; os.setsid(); from rig.sweeping.server import main; main(3)"

    def start_server(descriptor, environment):
        return warm_start.WarmProcess(
            (), program, stdout=1, stderr=2, environment=environment, more=[descriptor]
        )

    monkeypatch.setattr("rig.sweeping.pool._start_server", start_server)


@pytest.fixture
def pretended_hardware(tmp_path, monkeypatch):
    """Have emulated nodes in virtual time taken for real ones; return where profiles are kept.

    The folder has what ships, but no calibration and no acceptance test.
    """

    def build(profile, backend, on=None, frames=None):
        if backend is not Backend.HARDWARE:
            return build_rig(profile, backend, on, frames)
        made = build_virtual(profile, frames)
        made.backend = backend
        return made

    configs = tmp_path / "configs"
    shutil.copytree(CONFIGS, configs, ignore=shutil.ignore_patterns("calibration", "commissioning"))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")  # no record of this user's is found here
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr("rig.experiment.run.build_rig", build)
    return configs
