"""The path of one wire: from its anchor on the ring, round the ball, to its adjust point.

A taut wire without friction lies in the plane through the ball's centre and its two ends. There
the problem is flat: a circle, two points outside it or on it, and the shorter way round. All of
it follows from the two tangent points, so this needs no case for where the wire leaves the ball.
"""

import math

from drivers.sim.plants.compiled import inlined

_ANTIPODAL = 1e-12
"""Below this sine of the angle between the ends no plane is defined, and no arm."""


def wire_path(
    ax: float, ay: float, az: float, bx: float, by: float, bz: float, radius: float
) -> tuple[float, float, float, float, float]:
    """Return length, wrap and arm of the wire from anchor A to adjust point B.

    Parameters
    ----------
    ax, ay, az : float
        Anchor from the ball's centre, m; on the ball or outside it.
    bx, by, bz : float
        Adjust point from the ball's centre, m; outside the ball.
    radius : float
        Of the ball, m.

    Returns
    -------
    length : float
        m.
    wrap : float
        Angle of the ball that the wire touches, rad; 0 where it is free.
    arm_x, arm_y, arm_z : float
        Torque on the ring per newton of tension, m. A rotation of the ring at angular velocity
        w changes the length at the rate ``-arm . w``.
    """
    # In the wire's plane, with B on the first axis and A on the side of the second.
    b = math.sqrt(bx * bx + by * by + bz * bz)
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    area = math.sqrt(nx * nx + ny * ny + nz * nz)
    a1, a2 = (ax * bx + ay * by + az * bz) / b, area / b
    square = a1 * a1 + a2 * a2
    # Where the tangents from B and from A touch, each on the side that faces the other end.
    tangent_b = math.sqrt(b * b - radius * radius)
    tangent_a = math.sqrt(max(square - radius * radius, 0.0))
    leave1, leave2 = radius * radius / b, radius * tangent_b / b
    scale = radius / square
    touch1, touch2 = (
        scale * (radius * a1 + tangent_a * a2),
        scale * (radius * a2 - tangent_a * a1),
    )
    cross = leave1 * touch2 - leave2 * touch1
    if cross > 0.0:
        wrap = math.atan2(cross, leave1 * touch1 + leave2 * touch2)
        length = tangent_a + tangent_b + radius * wrap
        lever = radius / area if area > _ANTIPODAL * b * radius else 0.0
    else:
        wrap = 0.0
        length = math.sqrt((a1 - b) * (a1 - b) + a2 * a2)
        lever = 1.0 / length
    return length, wrap, lever * nx, lever * ny, lever * nz


compiled_wire_path = inlined(wire_path)
"""The same for kernels; plain Python needs no compiler to ask for a few lengths."""
