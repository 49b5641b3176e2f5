"""Forward kinematics: the ring's axis from four wires, and how well they agree.

Four lengths over two degrees of freedom leave two residuals. They are zero while all wires are
taut, the anchors are where the geometry says and the ring does not spin: a health signal.

The ring's spin is no third unknown: in a pose on the axes no length changes with it, and at 20
degrees elsewhere it would be 40 times less certain than the tilt. It is zero here (`natural`).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

from controllers.compiled import KernelMemory, PlainNumbers, inlined
from controllers.named_tuples import new_tuple
from controllers.spherical_joint.geometry import (
    Quadruple,
    SphericalJointGeometry,
    Vectors,
    of_each_wire,
)
from controllers.spherical_joint.poses import Vector

_MOST_ITERATIONS = 20
_MOST_STEP = 0.15
"""Of tan(tilt / 2) in one iteration; from home to 60 degrees it takes four."""
_MOST_AHEAD = 0.01
"""Of tan(tilt / 2) from one call to the next; what moves further has jumped."""
_SETTLED = 1e-5
"""A step below this leaves an error of its square."""

Plane = tuple[float, float]
Found = tuple[bool, Plane, Vector, Quadruple]
"""Whether the search has settled, p, the axis and the residuals (m); see `search`."""


@dataclass(frozen=True)
class SearchConstants(PlainNumbers):
    """The numbers that a search for the pose computes with.

    Parameters
    ----------
    radius, straight, squares, product : float
        r_c, m; t_b - r_c psi_w, m; r_c² + b², m²; r_c b, m².
    height, depth : float
        L and b_z, m.
    anchors, adjusts : tuple of tuple of float
        a at home and b of each wire, m.
    fixed : tuple of float
        Of each wire the part of A.b that does not change with p, m².
    homes : tuple of float
        Length of each wire at home, m, with the sign of a shortening.
    """

    radius: float
    straight: float
    squares: float
    product: float
    height: float
    depth: float
    anchors: Vectors
    adjusts: Vectors
    fixed: Quadruple
    homes: Quadruple


class ForwardPose(NamedTuple):
    """The ring's axis, and by how much the four wires disagree about it.

    Parameters
    ----------
    axis : tuple of float
        Unit vector.
    residuals : tuple of float
        Measured less computed shortening of each wire, m.
    """

    axis: Vector
    residuals: Quadruple

    @property
    def residual(self) -> float:
        """Root mean square of the residuals over the two lengths that are left, m."""
        first, second, third, fourth = self.residuals
        return math.sqrt(0.5 * (first * first + second * second + third * third + fourth * fourth))


class ForwardKinematics:
    """Least squares over the two tilts, by Gauss and Newton from the last pose.

    The tilt is carried as ``p = (u_x, u_y) / (1 + u_z)``, the tangent of half the tilt along its
    azimuth (the stereographic projection of the axis): no pose but straight down is singular, and
    a natural rotation is rational in it. With the anchor a = (a_h, L) and the adjust point
    b = (b_h, b_z), f = 2 / (1 + p.p), alpha = a_h.p and beta = b_h.p, the scalar product

        A.b = a_h.b_h - L b_z - f (alpha - L) (beta + b_z)

    is all that a wire's length depends on.

    Parameters
    ----------
    geometry : SphericalJointGeometry
        Dimensions; the wires are exact ones.
    """

    def __init__(self, geometry: SphericalJointGeometry) -> None:
        radius, distance = geometry.ball_radius, geometry.adjust_distance
        tangent = math.sqrt((distance - radius) * (distance + radius))
        anchors, adjusts = geometry.anchors, geometry.adjust_points
        constants = SearchConstants(
            radius,
            tangent - radius * math.atan2(tangent, radius),
            radius * radius + distance * distance,
            radius * distance,
            geometry.ring_height,
            -geometry.adjust_depth,
            anchors,
            adjusts,
            of_each_wire(lambda wire: _fixed_part(anchors[wire], adjusts[wire])),
            (0.0, 0.0, 0.0, 0.0),
        )
        homes = of_each_wire(lambda wire: _linearise(constants, wire, 0.0, 0.0, 2.0, 0.0)[0])
        self.constants = replace(constants, homes=homes)
        """For `search`."""
        self._search: Callable[[Plane, Quadruple], Found] = partial(search, self.constants)
        self._p = self._ahead = (0.0, 0.0)

    def reset(self) -> None:
        """Start the next search at home."""
        self._p = self._ahead = (0.0, 0.0)

    def compile(self) -> None:
        """Have the search compiled, for what is called in every cycle."""
        self._search = KernelMemory(self.constants).bind(search)
        self._search((0.0, 0.0), (0.0, 0.0, 0.0, 0.0))  # the first call is what compiles

    def update(self, shortening: Quadruple) -> ForwardPose:
        """Return the pose that explains four shortenings (m) best.

        Raises
        ------
        ValueError
            No pose does: the search does not settle.
        """
        last_x, last_y = self._p
        ahead_x, ahead_y = self._ahead
        settled, (p_x, p_y), axis, residuals = self._search(
            (last_x + ahead_x, last_y + ahead_y), shortening
        )
        if not settled:
            self.reset()
            raise unexplained(shortening)
        self._p = (p_x, p_y)
        self._ahead = step_ahead((last_x, last_y), self._p)
        return new_tuple(ForwardPose, (axis, residuals))


def _fixed_part(anchor: Vector, adjust: Vector) -> float:
    return anchor[0] * adjust[0] + anchor[1] * adjust[1] - anchor[2] * adjust[2]


def unexplained(shortening: Quadruple) -> ValueError:
    """Return what is said of four shortenings (m) that no pose explains."""
    told = ", ".join(f"{value * 1e3:.3f}" for value in shortening)
    return ValueError(f"no pose of the ring explains the shortenings {told} mm")


@inlined
def step_ahead(before: Plane, p: Plane) -> Plane:
    """Return how p goes on: a ring that goes on as it did is found in one iteration."""
    x, y = p[0] - before[0], p[1] - before[1]
    if abs(x) + abs(y) > _MOST_AHEAD:
        return 0.0, 0.0
    return x, y


@inlined
def search(constants: SearchConstants, start: Plane, shortening: Quadruple) -> Found:
    """Search for the pose from a first guess of p; see `ForwardKinematics`.

    Returns
    -------
    settled : bool
        It was found.
    p : tuple of float
        Tangent of half the tilt along its azimuth.
    axis : tuple of float
        The ring's, a unit vector.
    residuals : tuple of float
        Measured less computed shortening of each wire, m.
    """
    p_x, p_y = start
    homes = constants.homes
    step_x = step_y = 0.0
    first = second = third = fourth = (0.0, 0.0, 0.0)
    settled = False
    for _ in range(_MOST_ITERATIONS):
        share = 2.0 / (1.0 + p_x * p_x + p_y * p_y)
        first = _linearise(constants, 0, p_x, p_y, share, shortening[0] - homes[0])
        second = _linearise(constants, 1, p_x, p_y, share, shortening[1] - homes[1])
        third = _linearise(constants, 2, p_x, p_y, share, shortening[2] - homes[2])
        fourth = _linearise(constants, 3, p_x, p_y, share, shortening[3] - homes[3])
        xx = xy = yy = x = y = 0.0
        for residual, slope_x, slope_y in (first, second, third, fourth):
            xx += slope_x * slope_x
            xy += slope_x * slope_y
            yy += slope_y * slope_y
            x += slope_x * residual
            y += slope_y * residual
        determinant = xx * yy - xy * xy
        step_x = (yy * x - xy * y) / determinant
        step_y = (xx * y - xy * x) / determinant
        size = abs(step_x) + abs(step_y)
        if size > _MOST_STEP:
            step_x *= _MOST_STEP / size
            step_y *= _MOST_STEP / size
        p_x += step_x
        p_y += step_y
        if size < _SETTLED:
            settled = True
            break
    share = 2.0 / (1.0 + p_x * p_x + p_y * p_y)
    return (
        settled,
        (p_x, p_y),
        (share * p_x, share * p_y, share - 1.0),
        (
            first[0] - first[1] * step_x - first[2] * step_y,
            second[0] - second[1] * step_x - second[2] * step_y,
            third[0] - third[1] * step_x - third[2] * step_y,
            fourth[0] - fourth[1] * step_x - fourth[2] * step_y,
        ),
    )


@inlined
def _linearise(
    constants: SearchConstants, wire: int, p_x: float, p_y: float, share: float, measured: float
) -> tuple[float, float, float]:
    """Return residual (m) and slopes (m) of a wire's shortening at p.

    `measured` is the shortening less the length at home, m.
    """
    radius, product = constants.radius, constants.product
    a_x, a_y = constants.anchors[wire][0], constants.anchors[wire][1]
    b_x, b_y = constants.adjusts[wire][0], constants.adjusts[wire][1]
    alpha = a_x * p_x + a_y * p_y - constants.height
    beta = b_x * p_x + b_y * p_y + constants.depth
    bend = alpha * beta
    along = constants.fixed[wire] - share * bend
    if along < radius * radius:
        length = constants.straight + radius * math.acos(along / product)
        slope = radius / math.sqrt(product * product - along * along)
    else:
        length = math.sqrt(constants.squares - 2.0 * along)
        slope = 1.0 / length
    bent = share * share * bend
    return (
        measured + length,
        slope * (bent * p_x - share * (a_x * beta + alpha * b_x)),
        slope * (bent * p_y - share * (a_y * beta + alpha * b_y)),
    )
