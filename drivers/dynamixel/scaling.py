"""Codec of one joint: counts of its servo ↔ radians of the joint."""

from math import tau
from typing import NamedTuple

from drivers.dynamixel.registers import (
    COUNT_AT_ZERO,
    COUNTS_PER_TURN,
    MULTI_TURN_REACH,
    VELOCITY_STEP,
    Model,
)
from drivers.dynamixel.settings import DynamixelAxisSettings


class AxisScale(NamedTuple):
    """Straight lines between a servo and its joint.

    Attributes
    ----------
    step, origin : float
        ``angle = step · (counts - origin)``, rad; `step` has the sign of the direction.
    velocity_step : float
        ``velocity = velocity_step · counts``, rad/s.
    torque_step : float
        ``torque = torque_step · counts`` of current, N m.
    first, last : int
        The counts that the servo takes.
    """

    step: float
    origin: float
    velocity_step: float
    torque_step: float
    first: int
    last: int


def joint_scale(joint: DynamixelAxisSettings, model: Model, *, one_turn: bool) -> AxisScale:
    """Return the codec of a joint.

    Parameters
    ----------
    joint : DynamixelAxisSettings
        See there.
    model : Model
        The servo's.
    one_turn : bool
        Whether the servo stays within one turn.
    """
    turns = joint.turns_per_radian
    step = 1.0 / (turns * COUNTS_PER_TURN)
    reach = MULTI_TURN_REACH
    return AxisScale(
        step,
        COUNT_AT_ZERO - joint.offset / step,
        VELOCITY_STEP / (turns * tau),
        model.current_step * model.torque_constant * turns * tau,
        *((0, COUNTS_PER_TURN - 1) if one_turn else (-reach, reach)),
    )


def encode_position(scale: AxisScale, angle: float) -> int:
    """Return the counts for an angle, rad, rounded half to even and saturated."""
    counts = round(angle / scale.step + scale.origin)
    return scale.first if counts < scale.first else min(counts, scale.last)


def encode_velocity(scale: AxisScale, velocity: float) -> int:
    """Return the counts for a velocity, rad/s, rounded half to even."""
    return round(velocity / scale.velocity_step)


def decode_velocity(scale: AxisScale, counts: int) -> float:
    """Return the velocity for counts, rad/s."""
    return scale.velocity_step * counts
