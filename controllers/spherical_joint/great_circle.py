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
    across = tuple(
        b - a * sum(x * y for x, y in zip(start, end, strict=True))
        for a, b in zip(start, end, strict=True)
    )
    length = math.hypot(*across)
    if length < 1e-12:
        return JointReference(end, _ZERO, _ZERO)
    travel = math.atan2(length, sum(x * y for x, y in zip(start, end, strict=True)))
    angle, rate, rise = minimum_jerk(0.0, travel, duration, t)
    ahead = [x / length for x in across]
    c, s = math.cos(angle), math.sin(angle)
    axis = [c * a + s * b for a, b in zip(start, ahead, strict=True)]
    along = [c * b - s * a for a, b in zip(start, ahead, strict=True)]
    return JointReference(
        (axis[0], axis[1], axis[2]),
        (rate * along[0], rate * along[1], rate * along[2]),
        (
            rise * along[0] - rate * rate * axis[0],
            rise * along[1] - rate * rate * axis[1],
            rise * along[2] - rate * rate * axis[2],
        ),
    )
