"""The acceptance test of one antagonistic pair."""

from collections.abc import Sequence

from rig.commissioning.step import AcceptanceStep
from rig.commissioning.steps.motion import FirstMotion, Moved, by_law
from rig.mechanisms.cylinder.references import Staircase
from rig.mechanisms.cylinder.settings import CylinderSettings
from rig.mechanisms.pneumatic.commissioning.course import following, pneumatic_course
from rig.mechanisms.pneumatic.settings import PneumaticSettings

_TRAVEL = 1e-3
"""Of the first motion, m."""

_LAW = "pid-friction"
"""It swings least on cylinders and at rates that its gains were not tuned for: a PID that has
nothing but its integral against the seals' friction swings on one in fifteen drawn rigs."""


def steps() -> Sequence[AcceptanceStep]:
    """Return the steps in their order."""
    there_and_back = Staircase(levels=(0.0, _TRAVEL, 0.0), rise=2.0, dwell=1.0)
    moved = Moved(("reading.position",), _TRAVEL, "m")
    motion = by_law("staircase", there_and_back, _LAW)
    return pneumatic_course(FirstMotion(moved, motion, strays=following), _way)


def _way(settings: PneumaticSettings) -> float:
    """Return how far a rod goes from home where the profile permits most, m."""
    assert isinstance(settings, CylinderSettings)
    return max(map(abs, settings.limits.position))
