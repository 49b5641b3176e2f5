"""What must never be true of the cranks, whatever breaks: `rig faults` judges them by it."""

from crank_rig.crank.settings import CrankSettings
from rig.hal.hazards import Hazard

CRANKS = ("position_left", "position_right")


def crank_hazards(settings: CrankSettings) -> tuple[Hazard, ...]:
    """Return them: how far a crank may get, and how fast, a third beyond its limit."""
    reach, speed = settings.reach + 0.1, 1.3 * settings.max_speed
    return (
        Hazard("reach", "rad", CRANKS, -reach, reach),
        Hazard("speed", "rad/s", CRANKS, -speed, speed, is_rate=True),
    )
