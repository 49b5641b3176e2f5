"""The velocity inverse, decomposed into singular and other directions.

The paper's law is ``q' = b J^-1 v``; b goes to zero with whatever vanishes in J. Multiplied out,
each singular quotient stands alone, and the scalars `Scale` carry what is left of it: the caller
says what b is and what ``b / S3`` is, and so may go through ``S3 = 0``.
"""

import math
from typing import NamedTuple

from controllers.arm.kinematics import Dimensions, tool_axis_in_forearm
from controllers.arm.types import Joints, Vector
from controllers.compiled import inlined
from controllers.singularity.two_link import TipFrame, two_link_frame, two_link_parts


class Scale(NamedTuple):
    """Shares of the commanded twist, with the quotient that the elbow needs.

    Parameters
    ----------
    linear : float
        b: the tool moves with ``b v``.
    angular : float
        The tool turns with ``angular * w``: b², which keeps the sense of turning on a bounce.
    per_elbow : float
        ``b / S3``, finite at the elbow's singularity.
    """

    linear: float
    angular: float
    per_elbow: float


@inlined
def elbow_frame(arm: Dimensions, q2: float, q3: float) -> TipFrame:
    """Return the arm's radial direction and what moving along it costs; see `two_link_frame`.

    References
    ----------
    Miyata et al., eq. (5), (6), which leave out ``a2 = a3``; there the half angle is exact.
    """
    return two_link_frame(arm.a2, arm.a3, q2, q3 + arm.elbow_angle)


@inlined
def position_rates(arm: Dimensions, q: Joints, v: Vector, scale: Scale) -> Vector:
    """Return the rates of q1, q2, q3 (rad/s) that move the wrist centre with ``b v``.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    q : tuple of float
        Joints, rad.
    v : tuple of float
        The wrist centre's velocity per unit of b, base axes, m/s.
    scale : Scale
        b and ``b / S3``.

    Notes
    -----
    Where c is exactly zero, q1 is left alone: the velocity there is zero or the caller's b is.

    References
    ----------
    Miyata et al., eq. (2), (5), (6).
    """
    c1, s1 = math.cos(q[0]), math.sin(q[0])
    frame = elbow_frame(arm, q[1], q[2])
    c = frame.radius * frame.sine + arm.a1
    along_y = c1 * v[1] - s1 * v[0]
    turn = along_y / c if c != 0.0 else 0.0
    # The shoulder's offset makes q1 move the wrist within the arm's plane, too.
    in_plane = c1 * v[0] + s1 * v[1] + arm.offset * turn
    swing, stretch, bend = two_link_parts(arm.a2, arm.a3, frame, in_plane, v[2])
    b = scale.linear
    if arm.a2 == arm.a3 and abs(frame.radius) < arm.a2:
        # Folded: S3 vanishes as well, but radius / S3 is 1 / sin(q3 / 2).
        radial = frame.sine * in_plane + frame.cosine * v[2]
        fold = b * radial / (2.0 * arm.a3 * math.sin(0.5 * (q[2] + arm.elbow_angle)))
        return b * turn, b * swing + fold, -2.0 * fold
    per = scale.per_elbow
    return b * turn, b * swing + per * stretch, per * bend


@inlined
def wrist_turning(q: Joints, angular: Vector, position: Vector) -> Vector:
    """Return the angular velocity that the wrist's joints have to make, in the axes {W'}.

    Parameters
    ----------
    q : tuple of float
        Joints, rad.
    angular : tuple of float
        Of the tool, base axes, rad/s.
    position : tuple of float
        Rates of q1, q2, q3, rad/s.

    Returns
    -------
    tuple of float
        About x' (singular), y' (the axis of q5, up to sign) and z' (the forearm), rad/s.

    References
    ----------
    Miyata et al., eq. (3); section 2.2.2 names {W'} = {W} Rz(q4) and leaves the rest out.
    """
    c1, s1 = math.cos(q[0]), math.sin(q[0])
    q23 = q[1] + q[2]
    c23, s23 = math.cos(q23), math.sin(q23)
    c4, s4 = math.cos(q[3]), math.sin(q[3])
    x1 = c1 * angular[0] + s1 * angular[1]
    y = c1 * angular[1] - s1 * angular[0] - (position[1] + position[2])
    z1 = angular[2] - position[0]
    x = c23 * x1 - s23 * z1
    return c4 * x + s4 * y, c4 * y - s4 * x, s23 * x1 + c23 * z1


@inlined
def wrist_rates(arm: Dimensions, q: Joints, turning: Vector) -> Vector:
    """Return the rates of q4, q5, q6 (rad/s) that make a turning given in {W'}.

    Notes
    -----
    With ``S5 = 0`` a turning about x' is impossible and one about z' is shared freely between q4
    and q6; then q6 rests.

    References
    ----------
    Miyata et al., eq. (4), decomposed: ``w' = [S5 q6', q5', q4' + C5 q6']`` up to the wrist's sign.
    """
    s5 = math.sin(q[4])
    q6 = arm.wrist_sign * turning[0] / s5 if s5 != 0.0 else 0.0
    return turning[2] - math.cos(q[4]) * q6, arm.wrist_sign * turning[1], q6


@inlined
def joint_rates(
    arm: Dimensions, q: Joints, linear: Vector, angular: Vector, scale: Scale
) -> Joints:
    """Return the six joint rates (rad/s) that make ``(b v, angular_scale * w)`` at the tool.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    q : tuple of float
        Joints, rad.
    linear, angular : tuple of float
        The commanded twist v (m/s) and w (rad/s), base axes.
    scale : Scale
        How much of it is done.

    References
    ----------
    Miyata et al., eq. (1)-(6); below eq. (11) for ``p_W' = p_6' - d6 b w x R e_z``, which is
    why the angular scale over b, and not one, multiplies w in it.
    """
    axis = tool_axis_in_forearm(arm, q[3], q[4])
    c1, s1 = math.cos(q[0]), math.sin(q[0])
    q23 = q[1] + q[2]
    c23, s23 = math.cos(q23), math.sin(q23)
    x = c23 * axis[0] + s23 * axis[2]
    ax, ay, az = c1 * x - s1 * axis[1], s1 * x + c1 * axis[1], c23 * axis[2] - s23 * axis[0]
    lever = arm.d6 * (scale.angular / scale.linear if scale.linear != 0.0 else 0.0)
    wx, wy, wz = angular[0], angular[1], angular[2]
    v = (
        linear[0] - lever * (wy * az - wz * ay),
        linear[1] - lever * (wz * ax - wx * az),
        linear[2] - lever * (wx * ay - wy * ax),
    )
    q1, q2, q3 = position_rates(arm, q, v, scale)
    share = scale.angular
    turning = wrist_turning(q, (share * wx, share * wy, share * wz), (q1, q2, q3))
    q4, q5, q6 = wrist_rates(arm, q, turning)
    return q1, q2, q3, q4, q5, q6


def full_scale(arm: Dimensions, q: Joints) -> Scale:
    """Return the scale of the plain inverse, ``b = 1``.

    Raises
    ------
    ZeroDivisionError
        At the elbow's singularity, where the plain inverse does not exist.
    """
    return Scale(1.0, 1.0, 1.0 / math.sin(q[2] + arm.elbow_angle))
