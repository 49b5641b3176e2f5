"""The ray of one leg in closed form: the adjugate times any waist twist, in any posture."""

import math
from typing import NamedTuple

from controllers.gait.geometry import LegGeometry
from controllers.gait.kinematics import LegAngles, Vector


class LegRay(NamedTuple):
    """``adj(J) u`` of the six joints and ``det J``.

    Parameters
    ----------
    joints : tuple of float
        From the hip to the ankle.
    path : float
        m³.
    """

    joints: LegAngles
    path: float


def leg_ray(
    geometry: LegGeometry, leg: int, q: LegAngles, velocity: Vector, spin: Vector = (0.0, 0.0, 0.0)
) -> LegRay:
    """Return ``(adj(J) u, det J)`` without any division.

    The hip's three axes meet, so knee and ankle alone carry the hip centre's velocity; the hip
    then makes up the rotation that is left.

    Parameters
    ----------
    geometry : LegGeometry
        The legs.
    leg : int
        0 right, 1 left.
    q : tuple of float
        Joint angles, rad.
    velocity, spin : tuple of float
        u: of the waist seen from the foot, in the foot's frame, per path parameter.
    """
    thigh, shank = geometry.thigh, geometry.shank
    s2, c2 = math.sin(q[1]), math.cos(q[1])
    s5, c5 = math.sin(q[4]), math.cos(q[4])
    s45, c45 = math.sin(q[3] + q[4]), math.cos(q[3] + q[4])
    s6, c6 = math.sin(q[5]), math.cos(q[5])
    pitch = q[2] + q[3] + q[4]
    sp, cp = math.sin(pitch), math.cos(pitch)
    s1, c1 = math.sin(q[0]), math.cos(q[0])
    # Everything in the frame between the ankle's two joints.
    wx = spin[0]
    wy = c6 * spin[1] - s6 * spin[2]
    wz = s6 * spin[1] + c6 * spin[2]
    # The hip from the waist: along the waist's y axis, the second row of Rz(q1) Rx(q2) Ry(pitch).
    side = geometry.side(leg)
    hx = side * (s1 * cp + c1 * s2 * sp)
    hy = side * c1 * c2
    hz = side * (s1 * sp - c1 * s2 * cp)
    vx = velocity[0] + wy * hz - wz * hy
    vy = c6 * velocity[1] - s6 * velocity[2] + wz * hx - wx * hz
    vr = s6 * velocity[1] + c6 * velocity[2] + wx * hy - wy * hx
    rx = -shank * s5 - thigh * s45
    rz = shank * c5 + thigh * c45
    d = -thigh * shank * math.sin(q[3])
    n4 = rx * vx + rz * vr
    n5 = thigh * (s45 * vx - c45 * vr)
    # Rotation that is left for the hip, times d rz; then seen from the thigh's upper end.
    gx = -wx * d * rz - d * vy
    gy = -wy * d * rz - rz * (n4 + n5)
    gz = -wz * d * rz
    tx, tz = cp * gx + sp * gz, cp * gz - sp * gx
    return LegRay(
        (-tz, -c2 * tx, s2 * tz - c2 * gy, -c2 * rz * n4, -c2 * rz * n5, -c2 * d * vy),
        -d * rz * c2,
    )
