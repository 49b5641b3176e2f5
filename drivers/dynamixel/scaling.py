"""Codec of one joint: counts of its servo ↔ radians of the joint."""

from math import tau
from typing import NamedTuple

from drivers.dynamixel.registers import (
    COUNT_AT_ZERO,
    COUNTS_PER_TURN,
    MULTI_TURN_REACH,
    VELOCITY_STEP,
)
from drivers.dynamixel.settings import DynamixelJoint


class JointScale(NamedTuple):
    """Straight lines between a servo and its joint.

    Attributes
    ----------
    step, origin : float
        ``angle = step · (counts - origin)``, rad; `step` has the sign of the direction.
    velocity_step : float
        ``velocity = velocity_step · counts``, rad/s.
    current_step : float
        ``current = current_step · counts``, A, in the joint's sense.
    lower, upper : float
        The joint's range, rad.
    first, last : int
        The counts that the servo takes.
    """

    step: float
    origin: float
    velocity_step: float
    current_step: float
    lower: float
    upper: float
    first: int
    last: int


def joint_scale(joint: DynamixelJoint, current_step: float, *, one_turn: bool) -> JointScale:
    """Return the codec of a joint.

    Parameters
    ----------
    joint : DynamixelJoint
        See there.
    current_step : float
        Of the servo's model, A.
    one_turn : bool
        Whether the servo stays within one turn.
    """
    turns = joint.turns_per_radian
    sign = -1.0 if turns < 0.0 else 1.0
    step = 1.0 / (turns * COUNTS_PER_TURN)
    lower, upper = joint.limits
    reach = MULTI_TURN_REACH
    return JointScale(
        step,
        COUNT_AT_ZERO - joint.offset / step,
        VELOCITY_STEP / (turns * tau),
        sign * current_step,
        lower,
        upper,
        *((0, COUNTS_PER_TURN - 1) if one_turn else (-reach, reach)),
    )


def encode_position(scale: JointScale, angle: float) -> int:
    """Return the counts for an angle, rad, rounded half to even and saturated."""
    counts = round(angle / scale.step + scale.origin)
    return scale.first if counts < scale.first else min(counts, scale.last)


def decode_position(scale: JointScale, counts: int) -> float:
    """Return the angle for counts, rad."""
    return scale.step * (counts - scale.origin)


def encode_velocity(scale: JointScale, velocity: float) -> int:
    """Return the counts for a velocity, rad/s, rounded half to even."""
    return round(velocity / scale.velocity_step)


def decode_velocity(scale: JointScale, counts: int) -> float:
    """Return the velocity for counts, rad/s."""
    return scale.velocity_step * counts
