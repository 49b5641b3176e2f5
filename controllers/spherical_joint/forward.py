"""Forward kinematics: the ring's axis from four wires, and how well they agree.

Four lengths over two degrees of freedom leave two residuals. They are zero while all wires are
taut, the anchors are where the geometry says and the ring does not spin: a health signal.

The ring's spin is no third unknown: in a pose on the axes no length changes with it, and at 20
degrees elsewhere it would be 40 times less certain than the tilt. It is zero here (`natural`).
"""

import math
from typing import NamedTuple

from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.poses import Vector

_MOST_ITERATIONS = 20
_MOST_STEP = 0.15
"""Of tan(tilt / 2) in one iteration; from home to 60 degrees it takes four."""
_MOST_AHEAD = 0.01
"""Of tan(tilt / 2) from one call to the next; what moves further has jumped."""
_SETTLED = 1e-5
"""A step below this leaves an error of its square."""


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
        self._radius = radius
        self._radius_squared = radius * radius
        self._product = radius * distance
        self._squares = radius * radius + distance * distance
        self._straight = tangent - radius * math.atan2(tangent, radius)
        self._height = geometry.ring_height
        self._depth = -geometry.adjust_depth
        self._wires = tuple(
            (a[0], a[1], b[0], b[1], a[0] * b[0] + a[1] * b[1] - a[2] * b[2])
            for a, b in zip(geometry.anchors, geometry.adjust_points, strict=True)
        )
        self._p = self._ahead = (0.0, 0.0)
        self._homes: Quadruple = (0.0, 0.0, 0.0, 0.0)
        home = self._linearise(0.0, 0.0, (0.0, 0.0, 0.0, 0.0))
        first, second, third, fourth = (row[0] for row in home)
        self._homes = (first, second, third, fourth)

    def reset(self) -> None:
        """Start the next search at home."""
        self._p = self._ahead = (0.0, 0.0)

    def update(self, shortening: Quadruple) -> ForwardPose:
        """Return the pose that explains four shortenings (m) best.

        Raises
        ------
        ValueError
            No pose does: the search does not settle.
        """
        last_x, last_y = self._p
        ahead_x, ahead_y = self._ahead
        p_x, p_y = last_x + ahead_x, last_y + ahead_y
        for _ in range(_MOST_ITERATIONS):
            rows = self._linearise(p_x, p_y, shortening)
            xx = xy = yy = x = y = 0.0
            for residual, slope_x, slope_y in rows:
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
                break
        else:
            self.reset()
            raise ValueError(
                "no pose of the ring explains the shortenings "
                + ", ".join(f"{value * 1e3:.3f}" for value in shortening)
                + " mm"
            )
        self._p = (p_x, p_y)
        # A ring that goes on as it did is found in one iteration.
        ahead_x, ahead_y = p_x - last_x, p_y - last_y
        if abs(ahead_x) + abs(ahead_y) > _MOST_AHEAD:
            ahead_x = ahead_y = 0.0
        self._ahead = (ahead_x, ahead_y)
        share = 2.0 / (1.0 + p_x * p_x + p_y * p_y)
        first, second, third, fourth = (
            residual - slope_x * step_x - slope_y * step_y for residual, slope_x, slope_y in rows
        )
        return ForwardPose((share * p_x, share * p_y, share - 1.0), (first, second, third, fourth))

    def _linearise(
        self, p_x: float, p_y: float, shortening: Quadruple
    ) -> list[tuple[float, float, float]]:
        """Return residual (m) and slopes (m) of each wire's shortening at p."""
        radius, product, height, depth = self._radius, self._product, self._height, self._depth
        share = 2.0 / (1.0 + p_x * p_x + p_y * p_y)
        share_squared = share * share
        rows = []
        for (a_x, a_y, b_x, b_y, constant), home, measured in zip(
            self._wires, self._homes, shortening, strict=True
        ):
            alpha = a_x * p_x + a_y * p_y - height
            beta = b_x * p_x + b_y * p_y + depth
            bend = alpha * beta
            along = constant - share * bend
            if along < self._radius_squared:
                length = self._straight + radius * math.acos(along / product)
                slope = radius / math.sqrt(product * product - along * along)
            else:
                length = math.sqrt(self._squares - 2.0 * along)
                slope = 1.0 / length
            bent = share_squared * bend
            rows.append(
                (
                    measured - home + length,
                    slope * (bent * p_x - share * (a_x * beta + alpha * b_x)),
                    slope * (bent * p_y - share * (a_y * beta + alpha * b_y)),
                )
            )
        return rows
