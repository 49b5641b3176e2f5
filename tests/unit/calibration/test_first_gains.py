"""The program's own motions keep their gains, whatever a tuning made of the profile's laws."""

from dataclasses import replace

import pytest

from rig.assembly import REGISTRY
from rig.config import find_configs, load_profile
from rig.mechanisms.cylinder import first_gains as pair_gains
from rig.mechanisms.joint import first_gains as ring_gains

GAINS = {"cylinder": pair_gains, "joint": ring_gains}
RIGS = ("cylinder", "cylinder-low-speed", "cylinder-valves", "joint", "joint-valves")


def without(profile, law):
    """Return a profile that lacks a law."""
    laws = {name: gains for name, gains in profile.controllers.items() if name != law}
    return replace(profile, controllers=laws)


def tuned(profile, law):
    """Return a profile with a law whose stiffness is a tenth of what it was."""
    gains = profile.controllers[law]
    pair = getattr(gains, "pair", gains)
    softer = replace(pair, proportional=0.1 * pair.proportional)
    gains = softer if pair is gains else replace(gains, pair=softer)
    return replace(profile, controllers={**profile.controllers, law: gains})


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("spoil", [without, tuned])
def test_no_tuning_changes_the_gains_of_calibrations_and_first_motions(rig, spoil):
    profile = load_profile(rig, REGISTRY, (), find_configs())
    gains = GAINS[profile.mechanism]
    placing, law = gains.with_placing_law(profile)
    spoilt = spoil(placing, law)
    assert gains.with_placing_law(spoilt)[0].controllers[law] == placing.controllers[law]
    moving = gains.with_first_law(profile)
    spoilt = spoil(moving, gains.FIRST_LAW)
    first = gains.with_first_law(spoilt).controllers[gains.FIRST_LAW]
    assert first == moving.controllers[gains.FIRST_LAW]


@pytest.mark.parametrize("rig", RIGS)
def test_other_laws_and_all_else_of_the_profile_stay(rig):
    profile = load_profile(rig, REGISTRY, (), find_configs())
    gains = GAINS[profile.mechanism]
    for changed, law in (
        gains.with_placing_law(profile),
        (gains.with_first_law(profile), gains.FIRST_LAW),
    ):
        assert without(changed, law) == without(profile, law)


def test_a_joint_keeps_how_its_wires_and_poses_are_taken():
    options = ("controllers.pid.pose=paper", "controllers.pid-friction.wire=paper")
    profile = load_profile("joint-ideal", REGISTRY, options, find_configs())
    placing, law = ring_gains.with_placing_law(profile)
    assert placing.controllers[law].pose == "paper"
    moving = ring_gains.with_first_law(profile)
    assert moving.controllers[ring_gains.FIRST_LAW].wire == "paper"
