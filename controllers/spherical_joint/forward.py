"""Forward kinematics: the ring's axis from four wires, and how well they agree.

Four lengths over two degrees of freedom leave two residuals. They are zero while all wires are
taut, the anchors are where the geometry says and the ring does not spin: a health signal.

The ring's spin is no third unknown: in a pose on the axes no length changes with it, and at 20
degrees elsewhere it would be 40 times less certain than the tilt. It is zero here (`natural`).
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from controllers.compiled import inlined, kernel_of
from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.poses import Vector

_new = tuple.__new__  # makes a named tuple in half the time that its class takes

_MOST_ITERATIONS = 20
_MOST_STEP = 0.15
"""Of tan(tilt / 2) in one iteration; from home to 60 degrees it takes four."""
_MOST_AHEAD = 0.01
"""Of tan(tilt / 2) from one call to the next; what moves further has jumped."""
_SETTLED = 1e-5
"""A step below this leaves an error of its square."""


_Wire = tuple[float, float, float, float, float]
Wires = tuple[tuple[float, float, float, float, float, float], tuple[_Wire, _Wire, _Wire, _Wire]]
"""What the search computes with: r_c, t_b - r_c psi_w, r_c² + b², r_c b, L and b_z; of each wire
a_h, b_h and the part of A.b that does not change with p."""


class ForwardPose(NamedTuple):
    """Where the ring points, and how far the wires are from saying the same.

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
        first, second, third, fourth = (
            (a[0], a[1], b[0], b[1], a[0] * b[0] + a[1] * b[1] - a[2] * b[2])
            for a, b in zip(geometry.anchors, geometry.adjust_points, strict=True)
        )
        self._wires: Wires = (
            (
                radius,
                tangent - radius * math.atan2(tangent, radius),
                radius * radius + distance * distance,
                radius * distance,
                geometry.ring_height,
                -geometry.adjust_depth,
            ),
            (first, second, third, fourth),
        )
        one, two, three, four = (
            _linearise(self._wires, wire, 0.0, 0.0, 2.0, 0.0)[0] for wire in range(4)
        )
        self._homes: Quadruple = (one, two, three, four)
        self.constants = (self._wires, self._homes)
        """For `search`."""
        self._search: Callable[..., Any] = search
        self._p = self._ahead = (0.0, 0.0)

    def reset(self) -> None:
        """Start the next search at home."""
        self._p = self._ahead = (0.0, 0.0)

    def compile(self) -> None:
        """Have the search compiled, for what is called in every cycle."""
        self._search = kernel_of(search)

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
            self._wires, self._homes, (last_x + ahead_x, last_y + ahead_y), shortening
        )
        if not settled:
            self.reset()
            raise unexplained(shortening)
        self._p = (p_x, p_y)
        self._ahead = step_ahead((last_x, last_y), self._p)
        return _new(ForwardPose, (axis, residuals))


def unexplained(shortening: Quadruple) -> ValueError:
    """Return what is said of four shortenings (m) that no pose explains."""
    told = ", ".join(f"{value * 1e3:.3f}" for value in shortening)
    return ValueError(f"no pose of the ring explains the shortenings {told} mm")


@inlined
def step_ahead(before: tuple[float, float], p: tuple[float, float]) -> tuple[float, float]:
    """Return how p goes on: a ring that goes on as it did is found in one iteration."""
    x, y = p[0] - before[0], p[1] - before[1]
    if abs(x) + abs(y) > _MOST_AHEAD:
        return 0.0, 0.0
    return x, y


@inlined
def search(
    wires: Wires, homes: Quadruple, start: tuple[float, float], shortening: Quadruple
) -> tuple[bool, tuple[float, float], Vector, Quadruple]:
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
    step_x = step_y = 0.0
    first = second = third = fourth = (0.0, 0.0, 0.0)
    settled = False
    for _ in range(_MOST_ITERATIONS):
        share = 2.0 / (1.0 + p_x * p_x + p_y * p_y)
        first = _linearise(wires, 0, p_x, p_y, share, shortening[0] - homes[0])
        second = _linearise(wires, 1, p_x, p_y, share, shortening[1] - homes[1])
        third = _linearise(wires, 2, p_x, p_y, share, shortening[2] - homes[2])
        fourth = _linearise(wires, 3, p_x, p_y, share, shortening[3] - homes[3])
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
    wires: Wires, wire: int, p_x: float, p_y: float, share: float, measured: float
) -> tuple[float, float, float]:
    """Return residual (m) and slopes (m) of a wire's shortening at p.

    `measured` is the shortening less the length at home, m.
    """
    radius, straight, squares, product, height, depth = wires[0]
    a_x, a_y, b_x, b_y, constant = wires[1][wire]
    alpha = a_x * p_x + a_y * p_y - height
    beta = b_x * p_x + b_y * p_y + depth
    bend = alpha * beta
    along = constant - share * bend
    if along < radius * radius:
        length = straight + radius * math.acos(along / product)
        slope = radius / math.sqrt(product * product - along * along)
    else:
        length = math.sqrt(squares - 2.0 * along)
        slope = 1.0 / length
    bent = share * share * bend
    return (
        measured + length,
        slope * (bent * p_x - share * (a_x * beta + alpha * b_x)),
        slope * (bent * p_y - share * (a_y * beta + alpha * b_y)),
    )
