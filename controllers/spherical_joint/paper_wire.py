"""The wires as the paper computes them: an arc to the equator, then a straight line.

An approximation. Unless the wire lies in a plane through the ball's axis, the real one leaves the
ball elsewhere and the straight part of the paper's cuts into it; its length comes out too short, by
0.01 µm at 20 degrees of tilt and 37 µm at 60 (see `exact_wire`). Kept to reproduce the paper and to
show the difference.
"""

import math

from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.poses import Rotation, Vector, rotate


def paper_wire_length(anchor: Vector, adjust: Vector, radius: float) -> float:
    """Return the length of one wire after Kobayashi and Saito, section 3.3.

    Parameters
    ----------
    anchor : tuple of float
        A, on the ball, m.
    adjust : tuple of float
        B, below the equator, m.
    radius : float
        r_c of the ball, m.

    Returns
    -------
    float
        Length of arc AC and line CB, m.

    Raises
    ------
    ValueError
        The line AB passes through the ball's axis: C is not defined (Fig. 5).

    Notes
    -----
    An anchor below the equator has a straight wire: the arc to the equator would run backwards
    (2.7 mm too long at 40 degrees of tilt). The text before section 3.3 says as much: the wire is
    wound on the ball only within a range around home.

    References
    ----------
    Kobayashi and Saito, "Postural control of the wide angle spherical joint", eq. (7)-(13).
    """
    x, y, z = anchor
    a, b, c = adjust
    if z < 0.0:
        return math.sqrt((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2)
    # Eq. (7): D, where the line AB crosses the equator's plane.
    share = z / (z - c)
    d_x = x - (x - a) * share
    d_y = y - (y - b) * share
    # Eq. (8): C, on the equator in the direction of D.
    distance = math.hypot(d_x, d_y)
    if distance < 1e-9 * radius:
        raise ValueError("the line from anchor to adjust point passes through the ball's axis")
    alpha = radius * d_x / distance
    beta = radius * d_y / distance
    # Eq. (9)-(11): the arc AC. The half angle keeps what eq. (10) loses where A is near C.
    chord = math.sqrt((x - alpha) ** 2 + (y - beta) ** 2 + z * z)
    arc = 2.0 * radius * math.asin(min(1.0, chord / (2.0 * radius)))
    # Eq. (12), (13).
    return arc + math.sqrt((a - alpha) ** 2 + (b - beta) ** 2 + c * c)


class PaperWires:
    """Lengths of the four wires after the paper."""

    def __init__(self, geometry: SphericalJointGeometry) -> None:
        self._radius = geometry.ball_radius
        self._wires = tuple(zip(geometry.anchors, geometry.adjust_points, strict=True))

    def lengths(self, rotation: Rotation) -> Quadruple:
        """Return the lengths from anchor to adjust point, m; eq. (5) and (13).

        Raises
        ------
        ValueError
            A wire's line passes through the ball's axis; the wire's number is in the message.
        """
        radius = self._radius
        lengths = []
        for number, (home, adjust) in enumerate(self._wires, start=1):
            try:
                lengths.append(paper_wire_length(rotate(rotation, home), adjust, radius))
            except ValueError as error:
                raise ValueError(f"wire {number}: {error}") from error
        first, second, third, fourth = lengths
        return first, second, third, fourth
