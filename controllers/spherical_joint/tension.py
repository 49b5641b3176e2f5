"""Which tensions hold a pose, with every wire taut and the ring on its seat.

Four wires pull, the ring has three rotations: for each pose one direction remains in which the
tensions can grow without turning the ring. Where all four grow along it (force closure), any load
can be held and any slack taken out by pulling harder.
"""

import math

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.geometry import PAIRS, Quadruple, SphericalJointGeometry
from controllers.spherical_joint.poses import Rotation, Vector, move_axis, natural_rotation

_NO_LOAD = (0.0, 0.0, 0.0)
_BESIDE = (4e-4, 9e-4, 0.0)
"""How far beside a pose its shares are taken if they are not unique there, rad: not along any of
the anchors' azimuths. They move by less than 1e-4 over this."""


class SlackWire(ValueError):
    """No tensions hold the pose with every wire taut."""


class TensionDistribution:
    """The tensions of the four wires in a pose.

    Parameters
    ----------
    geometry : SphericalJointGeometry
        Dimensions; the wires are exact ones, without friction on the ball.
    """

    def __init__(self, geometry: SphericalJointGeometry) -> None:
        self._wires = ExactWires(geometry)
        self._half_angle = geometry.ring_half_angle
        self._vanishing = 1e-9 * geometry.ball_radius**3

    def shares(self, rotation: Rotation) -> Quadruple:
        """Return the tensions that turn the ring nowhere, as shares of their sum.

        A share that is not positive means that no four taut wires hold this pose.

        Returns
        -------
        tuple of float
            The null vector of the wires' 3 × 4 Jacobian, of sum 1.
        """
        first, second, third, fourth = self._wires.jacobian(rotation)
        a = _triple(second, third, fourth)
        b = -_triple(first, third, fourth)
        c = _triple(first, second, fourth)
        d = -_triple(first, second, third)
        total = a + b + c + d
        if abs(total) < self._vanishing:
            # No wire spins the ring where it tilts towards a wire: any two pairs are in balance.
            # The shares beside such a pose tend to a limit, which is the one without a jump.
            return self._limit_of_shares(rotation)
        scale = 1.0 / total
        return (scale * a, scale * b, scale * c, scale * d)

    def hold(
        self,
        rotation: Rotation,
        least: float,
        total: float = 0.0,
        load: Vector = _NO_LOAD,
    ) -> Quadruple:
        """Return the lowest tensions (N) that hold a pose.

        Parameters
        ----------
        rotation : Rotation
            The pose.
        least : float
            No wire has less tension, N.
        total : float
            Nor all together, N: co-contraction.
        load : tuple of float
            Torque on the ring beside that of the wires, in the base, N m. Its part about the
            ring's own axis is left to the seat: where the ring tilts towards a wire no tensions
            could hold it.

        Raises
        ------
        SlackWire
            The wires have no force closure here.
        """
        shares = self.shares(rotation)
        if min(shares) <= 0.0:
            number = shares.index(min(shares)) + 1
            raise SlackWire(
                f"wire {number} would have to push: no tensions hold this pose with all wires taut"
            )
        balance = (0.0, 0.0, 0.0, 0.0) if load == _NO_LOAD else self._balance(rotation, load)
        level = total - sum(balance)
        for tension, share in zip(balance, shares, strict=True):
            level = max(level, (least - tension) / share)
        first, second, third, fourth = (
            tension + level * share for tension, share in zip(balance, shares, strict=True)
        )
        return first, second, third, fourth

    def seating_margin(self, rotation: Rotation, tensions: Quadruple) -> float:
        """Return by how much the wires' net force stays within the ring's contact cone, rad.

        The ring touches the ball on a circle, which pushes it outwards along the ball's normals:
        together they balance any force within the cone of these normals, whose half angle is
        the ring's. Beyond it (negative) the ring lifts off on one side, unless its seat captures
        it. Without the friction of the seat.
        """
        x = y = z = 0.0
        for direction, tension in zip(self._wires.directions(rotation), tensions, strict=True):
            x += tension * direction[0]
            y += tension * direction[1]
            z += tension * direction[2]
        u_x, u_y, u_z = rotation[0][2], rotation[1][2], rotation[2][2]
        along = -(u_x * x + u_y * y + u_z * z)
        across = math.hypot(u_y * z - u_z * y, u_z * x - u_x * z, u_x * y - u_y * x)
        return self._half_angle - math.atan2(across, along)

    def _limit_of_shares(self, rotation: Rotation) -> Quadruple:
        """Return the shares of a pose beside, corrected so that they do not tilt the ring."""
        axis = (rotation[0][2], rotation[1][2], rotation[2][2])
        beside = self.shares(natural_rotation(move_axis(axis, _BESIDE, _NO_LOAD, 1.0)))
        x, y, z = (
            -sum(share * arm for share, arm in zip(beside, column, strict=True))
            for column in zip(*self._wires.jacobian(rotation), strict=True)
        )
        first, second, third, fourth = (
            share + correction
            for share, correction in zip(beside, self._balance(rotation, (x, y, z)), strict=True)
        )
        return first, second, third, fourth

    def _balance(self, rotation: Rotation, load: Vector) -> Quadruple:
        """Return tensions of sum 0 that balance the tilting part of a load, N."""
        rows = self._wires.jacobian(rotation)
        arms = [
            tuple(0.5 * (a - b) for a, b in zip(rows[one], rows[other], strict=True))
            for one, other in PAIRS
        ]
        ring_x, ring_y, _ = zip(*rotation, strict=True)
        (a, b), (c, d), (x, y) = (
            (
                sum(p * q for p, q in zip(vector, ring_x, strict=True)),
                sum(p * q for p, q in zip(vector, ring_y, strict=True)),
            )
            for vector in (*arms, load)
        )
        determinant = a * d - b * c
        tensions = [0.0, 0.0, 0.0, 0.0]
        differences = ((x * d - y * c) / determinant, (a * y - b * x) / determinant)
        for (one, other), difference in zip(PAIRS, differences, strict=True):
            tensions[one] = 0.5 * difference
            tensions[other] = -0.5 * difference
        first, second, third, fourth = tensions
        return first, second, third, fourth


def pair_pressures(
    tensions: Quadruple, area: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the mean and the differential pressure (Pa) of each pair that make given tensions.

    Parameters
    ----------
    tensions : tuple of float
        Of the four wires, N.
    area : float
        Effective area of one cylinder, m².

    Returns
    -------
    tuple of tuple of float
        For the pairs (1, 3) and (4, 2): mean, and agonist less antagonist.
    """
    (a, b), (c, d) = (
        ((tensions[one] + tensions[other]) * 0.5 / area, (tensions[one] - tensions[other]) / area)
        for one, other in PAIRS
    )
    return (a, b), (c, d)


def _triple(a: Vector, b: Vector, c: Vector) -> float:
    """Return ``a . (b x c)``."""
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
