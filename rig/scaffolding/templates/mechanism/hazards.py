"""What must never be true of the mechanism, whatever breaks: `rig faults` judges it by that."""

from rig.hal.hazards import Hazard
from rig.scaffolding.templates.mechanism.settings import MyRigSettings
from rig.scaffolding.templates.mechanism.types import AXES


def my_rig_hazards(settings: MyRigSettings) -> tuple[Hazard, ...]:
    """Return them: how far an axis may get, and how fast, a little beyond its limits."""
    reach, speed = settings.reach + 0.1, 1.3 * settings.max_speed
    positions = tuple(f"position_{name}" for name in AXES)
    return (
        Hazard("reach", "rad", positions, -reach, reach),
        Hazard("speed", "rad/s", positions, -speed, speed, is_rate=True),
    )
