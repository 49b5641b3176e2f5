"""A period of turning back at the boundary, written for numba.

In Python a period takes 80 µs; `turn_back` compiles what it calls.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from controllers.arm.decomposition import joint_rates
from controllers.arm.integration import LONGEST_STEP, combined, moved
from controllers.arm.kinematics import forward, wrist_in_plane
from controllers.arm.region import elbow_scale, pass_scale
from controllers.arm.types import Joints, Vector
from controllers.compiled import PlainNumbers, inlined


@dataclass(frozen=True)
class TurnNumbers(PlainNumbers):
    """The numbers that a line to the boundary and back is gone with.

    Parameters
    ----------
    a2, a3, d6, height, offset, elbow_angle, wrist_sign, a1 : float
        Those of `Dimensions`: functions that take an arm take these numbers.
    linear, angular : tuple of float
        The commanded twist on the way out, m/s and rad/s.
    origin, direction : tuple of float
        Of the line, m and of unit length.
    sin_qs, side : float
        Half width of the elbow's region, and the side that the elbow starts on.
    shoulder, wrist : float
        Half widths of the regions in which the paper slows down, m and sine of q5; 0: none.
    per_limit : tuple of float
        1 over the rates beyond which all joints are slowed, s/rad; 0: no limit.
    """

    a2: float
    a3: float
    d6: float
    height: float
    offset: float
    elbow_angle: float
    wrist_sign: float
    a1: float
    linear: Vector
    angular: Vector
    origin: Vector
    direction: Vector
    sin_qs: float
    side: float
    shoulder: float
    wrist: float
    per_limit: Joints


class TurnSample(NamedTuple):
    """An instant of the motion.

    Parameters
    ----------
    joints, rates : tuple of float
        rad and rad/s.
    linear, angular : float
        Scales of the commanded velocity and angular velocity.
    inside : bool
        Whether the elbow is in its region.
    distance : float
        Of the hand from the line's origin, along the line, m.
    """

    joints: Joints
    rates: Joints
    linear: float
    angular: float
    inside: bool
    distance: float


@inlined
def turning(turn: TurnNumbers, q: Joints) -> tuple[Joints, float, float]:
    """Return the joints' rates, rad/s, and the scales of velocity and angular velocity."""
    scale = elbow_scale(q[2] + turn.elbow_angle, turn.sin_qs, turn.side)
    r1, r2, r3, r4, r5, r6 = joint_rates(turn, q, turn.linear, turn.angular, scale)  # type: ignore[arg-type]
    c, _ = wrist_in_plane(turn, q[1], q[2])  # type: ignore[arg-type]
    share = pass_scale(c, turn.shoulder) * pass_scale(math.sin(q[4]), turn.wrist)
    g = turn.per_limit
    worst = max(
        abs(r1) * g[0], abs(r2) * g[1], abs(r3) * g[2],
        abs(r4) * g[3], abs(r5) * g[4], abs(r6) * g[5],
    )  # fmt: skip
    if worst > 1.0:
        share /= worst
    rates = (share * r1, share * r2, share * r3, share * r4, share * r5, share * r6)
    return rates, share * scale.linear, share * scale.angular


@inlined
def turn_sample(turn: TurnNumbers, q: Joints) -> TurnSample:
    """Return what there is to know of joints (rad) on the way."""
    rates, linear, angular = turning(turn, q)
    elbow = q[2] + turn.elbow_angle
    inside = math.cos(elbow) > 0.0 and abs(math.sin(elbow)) <= turn.sin_qs
    x, y, z = forward(turn, q).position  # type: ignore[arg-type]
    distance = (
        (x - turn.origin[0]) * turn.direction[0]
        + (y - turn.origin[1]) * turn.direction[1]
        + (z - turn.origin[2]) * turn.direction[2]
    )
    return TurnSample(q, rates, linear, angular, inside, distance)


@inlined
def turn_on(turn: TurnNumbers, q: Joints, rates: Joints, period: float) -> TurnSample:
    """Return the sample a period (s) after joints whose rates are known.

    Runge and Kutta's method, as `advance_joints` has it.
    """
    steps = max(1, math.ceil(period / LONGEST_STEP - 1e-9))
    h = period / steps
    half = 0.5 * h
    for step in range(steps):
        k1 = turning(turn, q)[0] if step else rates
        k2 = turning(turn, moved(q, k1, half))[0]
        k3 = turning(turn, moved(q, k2, half))[0]
        k4 = turning(turn, moved(q, k3, h))[0]
        q = combined(q, k1, k2, k3, k4, h)
    return turn_sample(turn, q)
