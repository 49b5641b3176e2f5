"""What the joint's dimensions are, as a profile gives them."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, TypeVar

from annotated_types import Gt, Unit

from controllers.spherical_joint.poses import Vector

Quadruple = tuple[float, float, float, float]
"""One value per wire, in the order of the channels."""
Pair = tuple[float, float]
"""One value per pair, (1, 3) and (4, 2)."""
Vectors = tuple[Vector, Vector, Vector, Vector]
"""One vector per wire."""
Value = TypeVar("Value")

PAIRS = ((0, 2), (3, 1))
"""Agonist and antagonist of each pair: the first tips the ring towards the first anchor (+Y in
the paper's arrangement), the second towards the fourth (+X)."""

_MOST_SKEW = math.radians(10.0)
"""By how much two anchors of a pair may miss being opposite, rad: a calibration's correction."""


def of_each_wire(value: Callable[[int], Value]) -> tuple[Value, Value, Value, Value]:
    """Return a value for each wire, 0 to 3."""
    return value(0), value(1), value(2), value(3)


@dataclass(frozen=True, slots=True)
class SphericalJointGeometry:
    """Dimensions of ball, ring, wires and marker.

    Frame: the origin is the ball's centre; at home the ring's axis is +Z and the wires go down.

    Parameters
    ----------
    ball_radius : float
        Radius of the ball that the wires run over, r_c, m.
    ring_radius : float
        r_ri, of the circle on the ball that the anchors lie on, m.
    anchor_angles : tuple of float
        phi_1 … phi_4, of anchors and adjust points about Z, rad; 1 and 3, 2 and 4 are opposite.
    adjust_radius : float
        Of the circle that the adjust points lie on, m; r_c in the paper.
    adjust_depth : float
        Of that circle below the ball's centre, m; r_c in the paper.
    marker_height : float
        Of the marker above the ball's centre, along the ring's axis, m.

    Raises
    ------
    ValueError
        The ring does not fit the ball, an adjust point is in the ball, or the wires do not form
        two opposite pairs.

    References
    ----------
    Kobayashi and Saito, "Postural control of the wide angle spherical joint", eq. (1)-(3) and
    section 6 (anchor angles). The paper gives no length but the circle's radius of 18 mm at 20
    degrees, from which the marker's height follows; ball and ring are chosen to meet eq. (17).
    """

    ball_radius: Annotated[float, Unit("m"), Gt(0)] = 25e-3
    ring_radius: Annotated[float, Unit("m"), Gt(0)] = 20e-3
    anchor_angles: tuple[
        Annotated[float, Unit("rad")],
        Annotated[float, Unit("rad")],
        Annotated[float, Unit("rad")],
        Annotated[float, Unit("rad")],
    ] = (0.5 * math.pi, math.pi, 1.5 * math.pi, 2.0 * math.pi)
    adjust_radius: Annotated[float, Unit("m"), Gt(0)] = 25e-3
    adjust_depth: Annotated[float, Unit("m"), Gt(0)] = 25e-3
    marker_height: Annotated[float, Unit("m"), Gt(0)] = 52.628e-3

    def __post_init__(self) -> None:
        if not self.ring_radius < self.ball_radius:
            raise ValueError(
                f"ring_radius ({self.ring_radius:g} m) must be less than ball_radius "
                f"({self.ball_radius:g} m): the anchors lie on the ball."
            )
        if math.hypot(self.adjust_radius, self.adjust_depth) <= self.ball_radius:
            raise ValueError(
                f"the adjust points (radius {self.adjust_radius:g} m, depth "
                f"{self.adjust_depth:g} m) lie inside the ball of {self.ball_radius:g} m."
            )
        if not self.marker_height > self.ring_height:
            raise ValueError(
                f"marker_height ({self.marker_height:g} m) must be above the ring, which is at "
                f"{self.ring_height:g} m."
            )
        angles = self.anchor_angles
        for one, other in PAIRS:
            skew = math.remainder(angles[one] - angles[other] - math.pi, math.tau)
            if abs(skew) > _MOST_SKEW:
                raise ValueError(
                    f"anchor_angles: wires {one + 1} and {other + 1} are a pair and must be "
                    f"opposite, but miss it by {math.degrees(skew):.4g} deg."
                )
        across = math.remainder(angles[0] - angles[3] - 0.5 * math.pi, math.pi)
        if abs(across) > 0.25 * math.pi:
            raise ValueError(
                "anchor_angles: the two pairs must stand across each other, but are "
                f"{90.0 - abs(math.degrees(across)):.4g} deg apart."
            )

    @property
    def ring_height(self) -> float:
        """L, of the anchors' circle above the ball's centre, m; eq. (3)."""
        return math.sqrt(
            (self.ball_radius - self.ring_radius) * (self.ball_radius + self.ring_radius)
        )

    @property
    def ring_half_angle(self) -> float:
        """Angle between the ring's axis and an anchor, seen from the ball's centre, rad."""
        return math.asin(self.ring_radius / self.ball_radius)

    @property
    def adjust_distance(self) -> float:
        """Of the adjust points from the ball's centre, m."""
        return math.hypot(self.adjust_radius, self.adjust_depth)

    @property
    def anchors(self) -> Vectors:
        """p_r at home, m; eq. (1), with a third row that makes z = L (printed: L/r_r)."""
        return self._circle(self.ring_radius, self.ring_height)

    @property
    def adjust_points(self) -> Vectors:
        """p_c, where the wires leave the joint, m; eq. (2)."""
        return self._circle(self.adjust_radius, -self.adjust_depth)

    def _circle(self, radius: float, height: float) -> Vectors:
        angles = self.anchor_angles
        return of_each_wire(
            lambda wire: (radius * math.cos(angles[wire]), radius * math.sin(angles[wire]), height)
        )

    def marker(self, axis: Vector) -> Vector:
        """Return the marker's position (m) for a ring axis."""
        height = self.marker_height
        return (height * axis[0], height * axis[1], height * axis[2])
