"""Gains of the program's own motions of a pair: through a calibration, and the first of all.

They come before anybody knows what a rig bears. So no profile tells them, and no tuning changes
them: gains that keep their margin on every drawn plant are too soft to break seals away that nobody
has measured, and healthy rigs would be refused.
"""

from dataclasses import replace
from typing import Final

from controllers.cylinder.pid import PidSettings
from controllers.cylinder.pid_friction import PidFrictionSettings
from rig.config import Profile

_PLACES: Final = PidSettings(proportional=6e6, integral=9e6, derivative=1.2e5)
"""Of a PID that takes a pair from place to place. Three times as stiff it swings between levels on
regulators of 0.67 of the speed. More integral makes a pair with little friction hunt."""

FIRST_LAW: Final = "pid-friction"
"""It swings least on cylinders and at rates that its gains were not tuned for: a PID that has
nothing but its integral against the seals' friction swings on one in fifteen drawn rigs."""

_MOVES_FIRST: Final = PidFrictionSettings(
    proportional=3e7, integral=1e8, derivative=3e5, lead_bandwidth=250.0, dither_amplitude=0.0
)
"""Behind regulators that are late its loop is stable by friction only: for a millimetre there and
back, not for work."""


def with_placing_law(profile: Profile) -> tuple[Profile, str]:
    """Return a profile with the law that takes a pair from place to place, and its name."""
    return replace(profile, controllers={**profile.controllers, "pid": _PLACES}), "pid"


def with_first_law(profile: Profile) -> Profile:
    """Return a profile with the law of the first motion."""
    return replace(profile, controllers={**profile.controllers, FIRST_LAW: _MOVES_FIRST})
