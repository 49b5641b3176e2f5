"""The acceptance test of two legs, which hang or stand in a frame that bears them."""

from collections.abc import Sequence

from controllers.gait.geometry import AXIS_NAMES
from rig.commissioning.step import AcceptanceStep
from rig.mechanisms.legs.commissioning_sensors import BalanceSensorsByHand
from rig.mechanisms.servo.commissioning.course import servo_course


def steps() -> Sequence[AcceptanceStep]:
    """Return the steps in their order."""
    return servo_course(AXIS_NAMES, (BalanceSensorsByHand(),))
