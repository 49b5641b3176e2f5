"""Limits that a pair's procedures widen: what wires stretch by at their pressures."""

import pytest

from rig.assembly import REGISTRY
from rig.config import find_configs, load_profile
from rig.mechanisms.cylinder.calibration.pneumatics import PairPneumatics


@pytest.mark.parametrize(("bore", "widened"), [(16, False), (25, True), (32, True)])
def test_rods_may_disagree_by_what_the_wires_stretch_at_the_pressures_of_a_procedure(bore, widened):
    said = [f"cylinder.bore={bore} mm", f"cylinder.rod={bore / 3.2} mm"]
    profile = load_profile("cylinder", REGISTRY, said, find_configs(None))
    settings = profile.mechanism_settings
    wider, notes = PairPneumatics(profile).with_wider_limits()
    mismatch = wider.mechanism_settings.limits.mismatch
    stretch = settings.area * settings.limits.pressure[1] / settings.wire_stiffness
    assert mismatch >= stretch
    assert (mismatch > settings.limits.mismatch) == widened
    assert any("limits.mismatch" in note for note in notes) == widened
