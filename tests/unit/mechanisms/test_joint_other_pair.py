"""A rod that strays is told with the chamber of the other pair, if that one lets the ring slide."""

import pytest
from joint_fakes import CHANNELS, JointBench
from pneumatic_fakes import BASE

from controllers.spherical_joint.geometry import PAIRS
from rig.mechanisms.pneumatic.alarms.tracking import Strayed

FOLLOWING = 3e-3


def held(weak, pull):
    """Return a joint that stands while the opponent of a chamber shows less than it, N."""
    bench = JointBench()
    pressures = [BASE] * 4
    pressures[weak] += pull / bench.joint.settings.area
    bench.regulators.reads = tuple(pressures)
    return bench.joint, bench.cycles(40)


def told(joint, state, rod, offs):
    error = Strayed("following error of a rod", 1.1 * FOLLOWING, -FOLLOWING, FOLLOWING, "m")
    error.rod, error.lasted, error.offs = rod, True, offs
    found = joint._watch.explain(error, state)
    return None if found is error else str(found)


@pytest.mark.parametrize("weak", range(4))
def test_a_pair_that_stays_off_though_it_is_pulled_back_is_why_the_other_strays(weak):
    pair = next(pair for pair in PAIRS if weak in pair)
    rod = next(one for one, _ in PAIRS if one not in pair)
    joint, _ = held(weak, 0.0)
    friction, following = joint._watch._balance._friction, joint.settings.limits.following
    for share, is_told in ((1.05, True), (0.95, False)):
        joint, state = held(weak, share * friction.coulomb)
        for off, names in ((0.52, True), (0.5, False), (-0.9, False)):
            offs = [0.0] * 4
            # The rods of a pair go to opposite sides; a chamber that pulls draws its own in.
            opponent = pair[1 - pair.index(weak)]
            offs[opponent], offs[weak] = off * following, -off * following
            said = told(joint, state, rod, offs)
            if is_told and names:
                assert f"the chamber of {CHANNELS[weak]} leaks behind its tube" in said
                assert "it stays off though" in said
            else:
                assert said is None
    assert told(joint, state, rod, ()) is None
