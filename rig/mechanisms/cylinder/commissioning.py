"""The acceptance test of one antagonistic pair."""

from collections.abc import Sequence

from rig.commissioning.step import AcceptanceStep
from rig.commissioning.steps.motion import FirstMotion
from rig.mechanisms.cylinder.references import Staircase
from rig.mechanisms.pneumatic.commissioning.course import pneumatic_course

_TRAVEL = 1e-3
"""Of the first motion, m."""


def steps() -> Sequence[AcceptanceStep]:
    """Return the steps in their order."""
    there_and_back = Staircase(levels=(0.0, _TRAVEL, 0.0), rise=2.0, dwell=1.0)
    motion = FirstMotion("staircase", there_and_back, ("reading.position",), _TRAVEL, "m")
    return pneumatic_course(motion)
