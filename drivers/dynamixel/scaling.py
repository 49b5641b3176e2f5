"""Codec of one joint: counts of its servo ↔ radians of the joint."""

from math import inf
from typing import NamedTuple

from drivers.dynamixel.registers import COUNT_AT_ZERO, POSITION_STEP, VELOCITY_STEP
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
    """

    step: float
    origin: float
    velocity_step: float
    current_step: float
    lower: float
    upper: float


def joint_scale(joint: DynamixelJoint, current_step: float, *, one_turn: bool) -> JointScale:
    """Return the codec of a joint.

    Parameters
    ----------
    joint : DynamixelJoint
        See there.
    current_step : float
        Of the servo's model, A.
    one_turn : bool
        Whether the servo stays within one turn, which then bounds the joint.
    """
    sign = float(joint.direction)
    step = sign * POSITION_STEP
    origin = COUNT_AT_ZERO + joint.zero / POSITION_STEP
    ends = sorted((step * (0 - origin), step * (2 * COUNT_AT_ZERO - 1 - origin)))
    lowest, highest = ends if one_turn else (-inf, inf)
    return JointScale(
        step,
        origin,
        sign * VELOCITY_STEP,
        sign * current_step,
        lowest if joint.lower is None else joint.lower,
        highest if joint.upper is None else joint.upper,
    )


def encode_position(scale: JointScale, angle: float) -> int:
    """Return the counts for an angle, rad, rounded half to even."""
    return round(angle / scale.step + scale.origin)


def decode_position(scale: JointScale, counts: int) -> float:
    """Return the angle for counts, rad."""
    return scale.step * (counts - scale.origin)


def encode_velocity(scale: JointScale, velocity: float) -> int:
    """Return the counts for a velocity, rad/s, rounded half to even."""
    return round(velocity / scale.velocity_step)


def decode_velocity(scale: JointScale, counts: int) -> float:
    """Return the velocity for counts, rad/s."""
    return scale.velocity_step * counts
