"""The acceptance test of one antagonistic pair."""

from collections.abc import Sequence

from rig.commissioning.step import AcceptanceStep
from rig.commissioning.steps.motion import FirstMotion, Moved, by_law
from rig.mechanisms.cylinder.first_gains import FIRST_LAW, with_first_law
from rig.mechanisms.cylinder.references import Staircase
from rig.mechanisms.cylinder.settings import CylinderSettings
from rig.mechanisms.pneumatic.commissioning.course import following, pneumatic_course
from rig.mechanisms.pneumatic.settings import PneumaticSettings

_TRAVEL = 1e-3
"""Of the first motion, m."""


def steps() -> Sequence[AcceptanceStep]:
    """Return the steps in their order."""
    there_and_back = Staircase(levels=(0.0, _TRAVEL, 0.0), rise=2.0, dwell=1.0)
    moved = Moved(("reading.position",), _TRAVEL, "m")
    motion = FirstMotion(
        moved,
        by_law("staircase", there_and_back, FIRST_LAW),
        prepared=lambda site: with_first_law(site.profile),
        strays=following,
    )
    return pneumatic_course(motion, _way)


def _way(settings: PneumaticSettings) -> float:
    """Return how far a rod goes from home where the profile permits most, m."""
    assert isinstance(settings, CylinderSettings)
    return max(map(abs, settings.limits.position))
