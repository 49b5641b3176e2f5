"""Where the waist is seen from a foot, and back; everything of one leg.

Positions are of the *hip centre from the ankle* in the foot's frame, because only three joints
(knee, ankle pitch and roll) move it; the waist and the sole are a constant offset away. Tuples of
floats: on the cycle small arrays cost ten times as much.
"""

import math

import numpy as np
from numpy.typing import NDArray

from controllers.gait.geometry import LegGeometry
from controllers.motion import InfeasibleMotion

Vector = tuple[float, float, float]
Rotation = tuple[Vector, Vector, Vector]
"""Rows of a rotation matrix."""
LegAngles = tuple[float, float, float, float, float, float]

UPRIGHT: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
"""A waist that is parallel to the foot."""

_TOUCH = 1e-12
"""Relative excess of the squared distance over the reach that is rounding, not a wish."""

_NEXT, _AFTER = [1, 2, 0], [2, 0, 1]
"""Of x, y and z the next axis, and the one after it."""


def hip_from_ankle(geometry: LegGeometry, q: LegAngles) -> Vector:
    """Return the hip centre from the ankle, in the foot's frame, m."""
    s6, c6 = math.sin(q[5]), math.cos(q[5])
    q45 = q[3] + q[4]
    height = geometry.shank * math.cos(q[4]) + geometry.thigh * math.cos(q45)
    forward = -geometry.shank * math.sin(q[4]) - geometry.thigh * math.sin(q45)
    return (forward, s6 * height, c6 * height)


def waist_rotation(q: LegAngles) -> Rotation:
    """Return the rotation foot from waist: its columns are the waist's axes."""
    s1, c1 = math.sin(q[0]), math.cos(q[0])
    s2, c2 = math.sin(q[1]), math.cos(q[1])
    pitch = q[2] + q[3] + q[4]
    sp, cp = math.sin(pitch), math.cos(pitch)
    s6, c6 = math.sin(q[5]), math.cos(q[5])
    # Waist from the frame between the ankle's joints: Rz(q1) Rx(q2) Ry(pitch).
    rows = (
        (c1 * cp - s1 * s2 * sp, -s1 * c2, c1 * sp + s1 * s2 * cp),
        (s1 * cp + c1 * s2 * sp, c1 * c2, s1 * sp - c1 * s2 * cp),
        (-c2 * sp, s2, c2 * cp),
    )
    first, second, third = zip(*rows, strict=True)
    # The foot is turned by +q6 about x from there, so it sees everything turned by -q6.
    return (first, _mix(c6, second, s6, third), _mix(-s6, second, c6, third))


def _mix(a: float, one: Vector, b: float, other: Vector) -> Vector:
    return (a * one[0] + b * other[0], a * one[1] + b * other[1], a * one[2] + b * other[2])


def waist_from_foot(geometry: LegGeometry, leg: int, q: LegAngles) -> tuple[Vector, Rotation]:
    """Return position (m) and rotation of the waist in a foot's frame.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    leg : int
        0 right, 1 left.
    q : tuple of float
        The leg's joint angles, rad.
    """
    x, y, z = hip_from_ankle(geometry, q)
    rotation = waist_rotation(q)
    side = geometry.side(leg)
    return (
        (
            x - side * rotation[0][1],
            y - side * rotation[1][1],
            z + geometry.ankle_height - side * rotation[2][1],
        ),
        rotation,
    )


def jacobian(geometry: LegGeometry, leg: int, q: LegAngles) -> NDArray[np.float64]:
    """Return the twist of the waist seen from the foot, per joint rate.

    Returns
    -------
    ndarray, shape (6, 6)
        Rows: velocity of the waist's origin (m), angular velocity (1), in the foot's frame.

    References
    ----------
    Kameta et al., section 4: J_R and J_L of eq. (3).
    """
    (x, y, z), rotation = waist_from_foot(geometry, leg, q)
    s5, c5 = math.sin(q[4]), math.cos(q[4])
    s6, c6 = math.sin(q[5]), math.cos(q[5])
    s1, c1 = math.sin(q[0]), math.cos(q[0])
    up = geometry.ankle_height
    hip_x, hip_y, hip_z = hip_from_ankle(geometry, q)
    hip = (hip_x, hip_y, hip_z + up)
    knee = (-geometry.shank * s5, geometry.shank * s6 * c5, up + geometry.shank * c6 * c5)
    ankle = (0.0, 0.0, up)
    yaw_axis = tuple([row[2] for row in rotation])
    roll_axis = tuple([c1 * row[0] + s1 * row[1] for row in rotation])
    pitch_axis = (0.0, c6, -s6)
    axes = np.array((yaw_axis, roll_axis, pitch_axis, pitch_axis, pitch_axis, (1.0, 0.0, 0.0)))
    levers = np.array((x, y, z)) - np.array((hip, hip, hip, knee, ankle, ankle))
    # The joint turns the foot against the waist, so the foot sees the waist turn the other way.
    # (np.cross takes as long as all of the rest.)
    velocities = axes[:, _NEXT] * levers[:, _AFTER] - axes[:, _AFTER] * levers[:, _NEXT]
    return -np.concatenate((velocities, axes), axis=1).T


def inverse(geometry: LegGeometry, hip: Vector, rotation: Rotation = UPRIGHT) -> LegAngles:
    """Return the joint angles that put the hip centre and the waist's axes where asked.

    The knee bends forwards (``q4 >= 0``); within a rounding of the reach it is straight.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    hip : tuple of float
        Hip centre from the ankle, in the foot's frame, m.
    rotation : tuple of tuple of float
        Foot from waist.

    Raises
    ------
    InfeasibleMotion
        The hip is farther from the ankle than the leg is long, or too near.
    """
    x, y, z = hip
    thigh, shank = geometry.thigh, geometry.shank
    height = math.hypot(y, z)
    # sin²(q4/2) instead of cos(q4): near the straight knee the cosine would lose half the digits.
    half = (geometry.reach**2 - x * x - height * height) / (4.0 * thigh * shank)
    if half < -_TOUCH or half > 1.0:
        raise InfeasibleMotion(
            f"the hip would be {math.hypot(x, height) * 1e3:.4f} mm from the ankle; the leg "
            f"reaches {abs(thigh - shank) * 1e3:g} … {geometry.reach * 1e3:g} mm."
        )
    knee = 2.0 * math.asin(math.sqrt(max(half, 0.0)))
    q6 = math.atan2(y, z)
    q5 = math.atan2(-x, height) - math.atan2(thigh * math.sin(knee), shank + thigh * math.cos(knee))
    if rotation is UPRIGHT:
        return (0.0, -q6, -knee - q5, knee, q5, q6)
    s6, c6 = math.sin(q6), math.cos(q6)
    first, second, third = rotation
    # Columns of the waist from the frame between the ankle's joints: Rz(q1) Rx(q2) Ry(pitch).
    across = _mix(c6, second, -s6, third)
    up = _mix(s6, second, c6, third)
    q2 = math.asin(min(max(across[2], -1.0), 1.0))
    q1 = math.atan2(-across[0], across[1])
    pitch = math.atan2(-first[2], up[2])
    return (q1, q2, math.remainder(pitch - knee - q5, math.tau), knee, q5, q6)
