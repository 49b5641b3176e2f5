"""Rods of a joint whose wires are not all of one length."""

import pytest

from rig.assembly import REGISTRY, Backend, build_rig
from rig.config import find_configs, load_profile


def test_each_rod_counts_from_its_own_home():
    options = ("joint.wire_offsets=[0.4 mm, 0 mm, -0.1 mm, 0 mm]", "plant.wire_offset=0 mm")
    profile = load_profile("joint", REGISTRY, options, find_configs())
    with build_rig(profile, Backend.SIM) as rig:
        rig.arm()
        state = rig.mechanism.read(rig.clock.now())
    # All of them stand out by home as the simulated joint was made.
    assert state.rods == pytest.approx((0.4e-3, 0.0, -0.1e-3, 0.0), abs=2e-6)
