"""The acceptance test of an arm."""

from collections.abc import Sequence

from controllers.arm.geometry import AXIS_NAMES
from rig.commissioning.step import AcceptanceStep
from rig.mechanisms.servo.commissioning.course import servo_course


def steps() -> Sequence[AcceptanceStep]:
    """Return the steps in their order."""
    return servo_course(AXIS_NAMES)
