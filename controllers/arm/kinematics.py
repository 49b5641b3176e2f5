"""Where the arm is: forward kinematics, Jacobians, singularity indices.

Plain functions of the dimensions and the joints, in Python floats.
"""

import math
from typing import NamedTuple

from controllers.arm.geometry import ArmGeometry
from controllers.arm.types import Joints, Pose, Vector
from controllers.compiled import inlined


class Dimensions(NamedTuple):
    """The numbers of an arm that its kinematics are computed with.

    An elbow offset only turns and lengthens the line from elbow to wrist centre, so it is gone
    here: `a3` is that line's length, and the elbow's angle is ``q3 + elbow_angle``.

    Parameters
    ----------
    a2, a3, d6 : float
        Upper arm, elbow to wrist centre, wrist centre to tool point, m.
    height : float
        Of the shoulder, m.
    offset : float
        Of the arm's plane from the axis of q1, m.
    elbow_angle : float
        rad.
    wrist_sign : float
        +1 or -1.
    a1 : float
        Of the shoulder from the axis of q1, within the arm's plane, m.
    """

    a2: float
    a3: float
    d6: float
    height: float
    offset: float
    elbow_angle: float
    wrist_sign: float
    a1: float = 0.0


class Indices(NamedTuple):
    """Factors of det J that vanish at the three singularities: det J = -a2 a3 S3 c S5.

    Parameters
    ----------
    shoulder : float
        c, signed distance of the wrist centre from the axis of q1 within the arm's plane, m.
    elbow : float
        S3, sine of the elbow's angle.
    wrist : float
        S5.
    """

    shoulder: float
    elbow: float
    wrist: float


def dimensions_of(geometry: ArmGeometry) -> Dimensions:
    """Return the numbers that the kinematics are computed with."""
    return Dimensions(
        geometry.a2,
        geometry.forearm,
        geometry.d6,
        geometry.base_height,
        geometry.shoulder_offset,
        geometry.elbow_angle,
        float(geometry.wrist_sign),
        geometry.a1,
    )


@inlined
def wrist_in_plane(arm: Dimensions, q2: float, q3: float) -> tuple[float, float]:
    """Return the wrist centre in the arm's plane: c from the axis of q1, and z from the shoulder.

    References
    ----------
    Miyata et al., section 2.2.1: ``c = a2 S2 + a3 S23``, whose shoulder is on the axis of q1.
    """
    q23 = q2 + q3 + arm.elbow_angle
    return (
        arm.a2 * math.sin(q2) + arm.a3 * math.sin(q23) + arm.a1,
        arm.a2 * math.cos(q2) + arm.a3 * math.cos(q23),
    )


@inlined
def tool_axis_in_forearm(arm: Dimensions, q4: float, q5: float) -> Vector:
    """Return the tool's axis in the axes of the forearm."""
    lean = arm.wrist_sign * math.sin(q5)
    return (lean * math.cos(q4), lean * math.sin(q4), math.cos(q5))


@inlined
def wrist_centre(arm: Dimensions, q: Joints) -> Vector:
    """Return the wrist centre in the base's axes, m."""
    c, z = wrist_in_plane(arm, q[1], q[2])
    c1, s1 = math.cos(q[0]), math.sin(q[0])
    return (c1 * c - s1 * arm.offset, s1 * c + c1 * arm.offset, z + arm.height)


@inlined
def base_from_forearm(q1: float, q23: float, v: Vector) -> Vector:
    """Turn a vector from the forearm's axes into the base's: ``Rz(q1) Ry(q2 + q3) v``."""
    c1, s1, c23, s23 = math.cos(q1), math.sin(q1), math.cos(q23), math.sin(q23)
    x = c23 * v[0] + s23 * v[2]
    return (c1 * x - s1 * v[1], s1 * x + c1 * v[1], c23 * v[2] - s23 * v[0])


@inlined
def forward(arm: Dimensions, q: Joints) -> Pose:
    """Return the tool's pose for the joints (rad).

    References
    ----------
    Miyata et al., eq. (1) in position: the tool point is d6 from the wrist centre.
    """
    q23 = q[1] + q[2]
    c4, s4, c6, s6 = math.cos(q[3]), math.sin(q[3]), math.cos(q[5]), math.sin(q[5])
    c5, s5 = math.cos(q[4]), arm.wrist_sign * math.sin(q[4])
    x = base_from_forearm(q[0], q23, (c4 * c5 * c6 - s4 * s6, s4 * c5 * c6 + c4 * s6, -s5 * c6))
    z = base_from_forearm(q[0], q23, (c4 * s5, s4 * s5, c5))
    y = (z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0])
    w = wrist_centre(arm, q)
    position = (w[0] + arm.d6 * z[0], w[1] + arm.d6 * z[1], w[2] + arm.d6 * z[2])
    return Pose(position, ((x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])))


def singularity_indices(arm: Dimensions, q: Joints) -> Indices:
    """Return c, S3 and S5."""
    c, _ = wrist_in_plane(arm, q[1], q[2])
    return Indices(c, math.sin(q[2] + arm.elbow_angle), math.sin(q[4]))


def link_points(arm: Dimensions, q: Joints) -> tuple[Vector, Vector, Vector, Vector, Vector]:
    """Return base, shoulder, elbow, wrist centre and tool point, m: the arm as a stick figure."""
    shoulder, elbow = _upper_arm(arm, q)
    return (0.0, 0.0, 0.0), shoulder, elbow, wrist_centre(arm, q), forward(arm, q).position


def _upper_arm(arm: Dimensions, q: Joints) -> tuple[Vector, Vector]:
    """Return shoulder and elbow in the base's axes, m."""
    c1, s1 = math.cos(q[0]), math.sin(q[0])
    shoulder = (c1 * arm.a1 - s1 * arm.offset, s1 * arm.a1 + c1 * arm.offset, arm.height)
    out = arm.a2 * math.sin(q[1])
    elbow = (
        shoulder[0] + c1 * out,
        shoulder[1] + s1 * out,
        shoulder[2] + arm.a2 * math.cos(q[1]),
    )
    return shoulder, elbow


def joint_axes(arm: Dimensions, q: Joints) -> tuple[tuple[Vector, Vector], ...]:
    """Return of each joint its axis and a point on it, in the base's axes."""
    q23 = q[1] + q[2]
    wrist = wrist_centre(arm, q)
    shoulder, elbow = _upper_arm(arm, q)
    across = (-math.sin(q[0]), math.cos(q[0]), 0.0)
    sign = arm.wrist_sign
    return (
        ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
        (across, shoulder),
        (across, elbow),
        (base_from_forearm(q[0], q23, (0.0, 0.0, 1.0)), wrist),
        (
            base_from_forearm(q[0], q23, (-sign * math.sin(q[3]), sign * math.cos(q[3]), 0.0)),
            wrist,
        ),
        (base_from_forearm(q[0], q23, tool_axis_in_forearm(arm, q[3], q[4])), wrist),
    )


def jacobian_columns(
    arm: Dimensions, q: Joints, point: Vector | None = None
) -> tuple[tuple[float, float, float, float, float, float], ...]:
    """Return the geometric Jacobian as six columns ``(v, w)`` in the base's axes.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    q : tuple of float
        Joints, rad.
    point : tuple of float, optional
        Whose linear velocity is meant, m; the tool point if left out. With the wrist centre the
        upper left 3 by 3 block is J_pv of eq. (2).
    """
    x, y, z = forward(arm, q).position if point is None else point
    columns = []
    for (ax, ay, az), (px, py, pz) in joint_axes(arm, q):
        rx, ry, rz = x - px, y - py, z - pz
        columns.append((ay * rz - az * ry, az * rx - ax * rz, ax * ry - ay * rx, ax, ay, az))
    return tuple(columns)


def hand_twist(
    arm: Dimensions, q: Joints, rates: Joints, point: Vector | None = None
) -> tuple[float, ...]:
    """Return the hand's velocity (m/s) and angular velocity (rad/s), base axes: ``J q'``.

    Who knows the tool point for these joints already, gives it: then it is not computed again.
    """
    columns = jacobian_columns(arm, q, point)
    return tuple(
        [
            sum([column[row] * rate for column, rate in zip(columns, rates, strict=True)])
            for row in range(6)
        ]
    )


def wrist_velocity(arm: Dimensions, linear: Vector, angular: Vector, tool_axis: Vector) -> Vector:
    """Return the wrist centre's velocity for the tool's twist, m/s.

    References
    ----------
    Miyata et al., eq. (1): ``p_W' = p_6' - d6 w_6 x (R e_z)``.
    """
    wx, wy, wz = angular
    ax, ay, az = tool_axis
    return (
        linear[0] - arm.d6 * (wy * az - wz * ay),
        linear[1] - arm.d6 * (wz * ax - wx * az),
        linear[2] - arm.d6 * (wx * ay - wy * ax),
    )
