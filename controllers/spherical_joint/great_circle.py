"""The shortest way of the ring's axis from pose to pose."""

import math

from controllers.minimum_jerk import minimum_jerk
from controllers.spherical_joint.poses import Vector
from controllers.spherical_joint.types import JointReference

_ZERO: Vector = (0.0, 0.0, 0.0)


def great_circle(start: Vector, end: Vector, duration: float, t: float) -> JointReference:
    """Return the minimum-jerk motion of the axis on the shortest way between two poses.

    Parameters
    ----------
    start, end : tuple of float
        Unit vectors, not opposite.
    duration : float
        s; outside 0 … `duration` the motion rests at its ends.
    t : float
        s.
    """
    (ax, ay, az), (bx, by, bz) = start, end
    shared = ax * bx + ay * by + az * bz
    x, y, z = bx - ax * shared, by - ay * shared, bz - az * shared
    length = math.hypot(x, y, z)
    if length < 1e-12:
        return JointReference(end, _ZERO, _ZERO)
    angle, rate, rise = minimum_jerk(0.0, math.atan2(length, shared), duration, t)
    x, y, z = x / length, y / length, z / length
    c, s = math.cos(angle), math.sin(angle)
    axis = (c * ax + s * x, c * ay + s * y, c * az + s * z)
    dx, dy, dz = c * x - s * ax, c * y - s * ay, c * z - s * az
    inwards = rate * rate
    return JointReference(
        axis,
        (rate * dx, rate * dy, rate * dz),
        (
            rise * dx - inwards * axis[0],
            rise * dy - inwards * axis[1],
            rise * dz - inwards * axis[2],
        ),
    )
