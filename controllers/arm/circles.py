"""Circles that touch the workspace's boundary or pass through the axis of q1.

On such a circle the hand's velocity in the singular direction vanishes as S3 or c do, so the
quotient is finite and the arm goes through the singularity without any slowing.
"""

import math

from controllers.arm.decomposition import (
    Scale,
    elbow_frame,
    position_rates,
    wrist_rates,
    wrist_turning,
)
from controllers.arm.kinematics import Dimensions
from controllers.arm.types import Joints, Vector


def elbow_rate(
    arm: Dimensions, r1: float, r2: float, gamma: float, gamma_rate: float, q3: float, side: float
) -> float:
    """Return q3' (rad/s) on a circle that touches the boundary at ``gamma = 0``.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    r1, r2 : float
        Shoulder to the circle's centre, and the circle's radius, m; their sum is the reach.
    gamma, gamma_rate : float
        Angle on the circle from the touch, rad, and its rate, rad/s.
    q3 : float
        rad.
    side : float
        Sign of S3 for positive gamma.

    References
    ----------
    Miyata et al., eq. (6)-(8), corrected: ``sin(gamma/2)`` is in numerator and denominator.
    """
    root = math.sqrt(r1 * r2 / (arm.a2 * arm.a3))
    half = 0.5 * (q3 + arm.elbow_angle)
    return side * gamma_rate * root * math.cos(0.5 * gamma) / math.cos(half)


def elbow_circle_rates(
    arm: Dimensions,
    q: Joints,
    velocity: Vector,
    elbow: float,
) -> Joints:
    """Return the joint rates on a circle through the elbow's singularity, the tool not turning.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    q : tuple of float
        Joints, rad.
    velocity : tuple of float
        Of the wrist centre, base axes, m/s.
    elbow : float
        q3' by `elbow_rate`, rad/s.
    """
    # What the radial velocity needs of q2 is a fixed share of q3', so no quotient is left.
    _, _, radius, lever = elbow_frame(arm, q[1], q[2])
    q1, swing, _ = position_rates(arm, q, velocity, Scale(1.0, 1.0, 0.0))
    position = (q1, swing - lever / radius * elbow, elbow)
    return (*position, *wrist_rates(arm, q, wrist_turning(q, (0.0, 0.0, 0.0), position)))


def shoulder_circle_rates(
    arm: Dimensions, q: Joints, velocity: Vector, gamma_rate: float
) -> Joints:
    """Return the joint rates on a horizontal circle through the axis of q1, the tool not turning.

    Notes
    -----
    ``v_y / c = (r1 gamma' sin(gamma/2)) / (2 r1 sin(gamma/2))``: q1 turns at half the circle's
    rate throughout, and c becomes negative: the arm reaches over its back.

    References
    ----------
    Miyata et al., eq. (6), (9), (10).
    """
    q1 = 0.5 * gamma_rate
    c1, s1 = math.cos(q[0]), math.sin(q[0])
    # Without its part across the arm's plane the velocity asks nothing of q1.
    ahead = c1 * velocity[0] + s1 * velocity[1]
    in_plane = (c1 * ahead, s1 * ahead, velocity[2])
    scale = Scale(1.0, 1.0, 1.0 / math.sin(q[2] + arm.elbow_angle))
    _, q2, q3 = position_rates(arm, q, in_plane, scale)
    position = (q1, q2, q3)
    return (*position, *wrist_rates(arm, q, wrist_turning(q, (0.0, 0.0, 0.0), position)))
