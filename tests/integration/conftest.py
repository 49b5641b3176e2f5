"""What whole runs share."""

import dataclasses

import pytest
from broken_package import plug_in

from rig.experiment import frozen

__all__ = ["plug_in"]
_FREEZES = {}


@pytest.fixture(autouse=True)
def _remembered_freezes(monkeypatch):
    """Try a plan's frozen setpoints on the plant once: every run on hardware asks for the same.

    It takes a second and more, and `closed_loop/test_frozen_setpoints.py` has no part in this.
    """
    longest_freeze = frozen.longest_freeze

    def remembered(plan, say=lambda _: None):
        simulation = dataclasses.replace(plan.profile.simulation, faults=())
        profile = dataclasses.replace(plan.profile, simulation=simulation)
        key = repr((profile, plan.experiment))
        if key not in _FREEZES:
            _FREEZES[key] = longest_freeze(plan, say)
        return _FREEZES[key]

    monkeypatch.setattr(frozen, "longest_freeze", remembered)
