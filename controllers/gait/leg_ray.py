"""The ray of one leg in closed form, in scalars.

Two forms. `leg_ray` takes any waist twist and any posture and is the adjugate, term by term.
`upright_ray` is what remains of it while the waist stays parallel to the foot (the gait): the same
direction, divided by the two factors of the determinant that do not vanish there.
"""

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


class UprightRay(NamedTuple):
    """The three rates that count while the waist stays upright, up to one scale.

    Hip yaw stands still, hip roll undoes the ankle's roll, hip pitch the sum of knee and ankle.

    Parameters
    ----------
    knee, ankle_pitch, ankle_roll : float
        Joint rates per scale.
    path : float
        Rate of the path parameter per scale; never negative with the knee bent forwards.
    """

    knee: float
    ankle_pitch: float
    ankle_roll: float
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


def upright_ray(
    thigh: float,
    shank: float,
    knee: float,
    ankle_pitch: float,
    ankle_roll: float,
    velocity: Vector,
) -> UprightRay:
    """Return the ray of a leg under an upright waist.

    Parameters
    ----------
    thigh, shank : float
        Lengths, m.
    knee, ankle_pitch, ankle_roll : float
        Joint angles, rad.
    velocity : tuple of float
        Of the waist seen from the foot, per path parameter, m.
    """
    q45 = knee + ankle_pitch
    s45, c45 = math.sin(q45), math.cos(q45)
    s6, c6 = math.sin(ankle_roll), math.cos(ankle_roll)
    forward = -shank * math.sin(ankle_pitch) - thigh * s45
    height = shank * math.cos(ankle_pitch) + thigh * c45
    path = thigh * shank * math.sin(knee)
    vx, vy, vz = velocity
    radial = vy * s6 + vz * c6
    return UprightRay(
        -forward * vx - height * radial,
        thigh * (c45 * radial - s45 * vx),
        path * (vy * c6 - vz * s6) / height,
        path,
    )
