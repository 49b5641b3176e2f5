"""Gains of the program's own motions of a joint: to a caliper, and the first of all.

As those of a pair (`rig.mechanisms.cylinder.first_gains`), for a ring that is heavier and sticks
more. What slides it evenly along its ball is the cascade (`rig.mechanisms.joint.calibration`).
"""

from dataclasses import replace
from typing import Final

from controllers.cylinder.pid import PidSettings
from controllers.cylinder.pid_friction import PidFrictionSettings
from controllers.spherical_joint.laws import JointPidFrictionSettings, JointPidSettings
from rig.config import Profile

FIRST_LAW: Final = "pid-friction"
"""As of a pair."""

_PLACES: Final = PidSettings(proportional=3e7, integral=1e8, derivative=2e6)
"""Of each pair, from place to place."""

_MOVES_FIRST: Final = PidFrictionSettings(
    proportional=5.1e7, integral=5e8, derivative=3e5, lead_bandwidth=350.0, dither_amplitude=800.0
)
"""Of each pair in the first motion."""


def with_placing_law(profile: Profile) -> tuple[Profile, str]:
    """Return a profile with the law that takes rods to a caliper, and its name."""
    usual = profile.controllers.get("pid", JointPidSettings())
    placing = replace(usual, pair=_PLACES)
    return replace(profile, controllers={**profile.controllers, "pid": placing}), "pid"


def with_first_law(profile: Profile) -> Profile:
    """Return a profile with the law of the first motion."""
    usual = profile.controllers.get(FIRST_LAW, JointPidFrictionSettings())
    moving = replace(usual, pair=_MOVES_FIRST)
    return replace(profile, controllers={**profile.controllers, FIRST_LAW: moving})
