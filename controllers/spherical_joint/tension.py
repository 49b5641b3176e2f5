"""Which tensions hold a pose, with every wire taut and the ring on its seat.

Four wires pull, the ring has three rotations: for each pose one direction remains in which the
tensions can grow without turning the ring. Where all four grow along it (force closure), any load
can be held and any slack taken out by pulling harder.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from controllers.compiled import KernelMemory, inlined
from controllers.spherical_joint.exact_wire import (
    ExactWires,
    WireConstants,
    wire_jacobian,
)
from controllers.spherical_joint.geometry import PAIRS, Quadruple, SphericalJointGeometry, Vectors
from controllers.spherical_joint.poses import Rotation, Vector, move_axis, natural_rotation
from controllers.spherical_joint.taut import PoseTensions, raised

_NO_LOAD = (0.0, 0.0, 0.0)
_BESIDE = (4e-4, 9e-4)
"""How far beside a pose its shares are taken if they are not unique there, rad: not along any of
the anchors' azimuths, and away from home, where they are not unique either. They move by less
than 1e-4 over this."""
_Tensions = tuple[Quadruple, Quadruple, Quadruple]


@inlined
def pose_tensions(wires: WireConstants, rotation: Rotation) -> _Tensions:
    """Return what makes up the `PoseTensions` of a pose."""
    rows = wire_jacobian(wires, rotation)
    tilts = (
        _tilt(rotation, rows[0]),
        _tilt(rotation, rows[1]),
        _tilt(rotation, rows[2]),
        _tilt(rotation, rows[3]),
    )
    (one, other), (third, fourth) = PAIRS
    a = 0.5 * (tilts[one][0] - tilts[other][0])
    b = 0.5 * (tilts[one][1] - tilts[other][1])
    c = 0.5 * (tilts[third][0] - tilts[fourth][0])
    d = 0.5 * (tilts[third][1] - tilts[fourth][1])
    scale = 1.0 / (a * d - b * c)
    (u1, v1), (u2, v2), (u3, v3), (u4, v4) = tilts
    first = (
        scale * (u1 * d - v1 * c),
        scale * (u2 * d - v2 * c),
        scale * (u3 * d - v3 * c),
        scale * (u4 * d - v4 * c),
    )
    second = (
        scale * (v1 * a - u1 * b),
        scale * (v2 * a - u2 * b),
        scale * (v3 * a - u3 * b),
        scale * (v4 * a - u4 * b),
    )
    unique, shares = _null_vector(rows, wires.vanishing)
    if not unique:
        shares = _limit_of_shares(wires, rotation, first, second)
    return shares, first, second


@inlined
def pose_shares(wires: WireConstants, rotation: Rotation) -> Quadruple:
    """Return the tensions that turn the ring nowhere, of sum 1; see `pose_tensions`."""
    unique, shares = _null_vector(wire_jacobian(wires, rotation), wires.vanishing)
    return shares if unique else pose_tensions(wires, rotation)[0]


@inlined
def _tilt(rotation: Rotation, row: Vector) -> tuple[float, float]:
    """Return by how much a newton in a wire tilts the ring, about its own X and Y."""
    (x, p, _), (y, q, _), (z, r, _) = rotation
    a, b, c = row
    return x * a + y * b + z * c, p * a + q * b + r * c


@inlined
def _null_vector(rows: Vectors, vanishing: float) -> tuple[bool, Quadruple]:
    """Return whether the Jacobian has one null vector, and it, of sum 1."""
    first, second, third, fourth = rows
    a = _triple(second, third, fourth)
    b = -_triple(first, third, fourth)
    c = _triple(first, second, fourth)
    d = -_triple(first, second, third)
    total = a + b + c + d
    if abs(total) < vanishing:
        return False, (0.0, 0.0, 0.0, 0.0)
    scale = 1.0 / total
    return True, (scale * a, scale * b, scale * c, scale * d)


@inlined
def _limit_of_shares(
    wires: WireConstants, rotation: Rotation, first: Quadruple, second: Quadruple
) -> Quadruple:
    """Return the shares where the ring tilts towards a wire.

    No wire spins the ring there, and any two pairs are in balance. The shares beside such a
    pose tend to a limit, the choice without a jump; corrected so that they tilt nothing.
    """
    x, y, z = rotation[0][2], rotation[1][2], rotation[2][2]
    unique, beside = False, (0.0, 0.0, 0.0, 0.0)
    reach = 1.0
    while not unique:  # small rings need more before their wires spin them at all
        off = (math.copysign(reach * _BESIDE[0], x), math.copysign(reach * _BESIDE[1], y), 0.0)
        rows = wire_jacobian(wires, natural_rotation(move_axis((x, y, z), off, _NO_LOAD, 1.0)))
        unique, beside = _null_vector(rows, wires.vanishing)
        reach *= 2.0
    return without_tilt(beside, first, second)


@inlined
def without_tilt(shares: Quadruple, first: Quadruple, second: Quadruple) -> Quadruple:
    """Return shares corrected within each pair so that they tilt nothing."""
    # The pairs are (1, 3) and (4, 2), see `PAIRS`.
    a, b, c, d = shares
    one = 0.5 * (first[0] * a + first[1] * b + first[2] * c + first[3] * d)
    other = 0.5 * (second[0] * a + second[1] * b + second[2] * c + second[3] * d)
    return (a - one, b + other, c + one, d - other)


def _regular(geometry: SphericalJointGeometry) -> SphericalJointGeometry | None:
    """Return the geometry with its anchors exactly across each other; None if they are."""
    angles = geometry.anchor_angles
    quarters = [0.5 * math.pi * round((angle - angles[0]) / (0.5 * math.pi)) for angle in angles]
    middle = sum(a - q for a, q in zip(angles, quarters, strict=True)) / len(angles)
    off = [abs(a - middle - q) for a, q in zip(angles, quarters, strict=True)]
    first, second, third, fourth = (middle + quarter for quarter in quarters)
    across = (first, second, third, fourth)
    return None if max(off) < 1e-9 else replace(geometry, anchor_angles=across)


class TensionDistribution:
    """The tensions of the four wires in a pose.

    Measured anchors are not exactly across each other. Near a pose that tilts towards a wire they
    turn the spin that is left there by small angles alone: shares that balance it grow without
    bound. The shares are then the regular joint's, corrected so that they tilt nothing; the spin
    that is left, below 1e-4 of what the wires could do with anchors half a degree off, is the
    seat's friction's to hold.

    Parameters
    ----------
    geometry : SphericalJointGeometry
        Dimensions; the wires are exact ones, without friction on the ball.
    """

    def __init__(self, geometry: SphericalJointGeometry) -> None:
        self._wires = ExactWires(geometry)
        regular = _regular(geometry)
        self._regular = None if regular is None else ExactWires(regular)
        self._half_angle = geometry.ring_half_angle
        self.wires = self._wires.constants
        """Of the wires."""
        self.regular = None if self._regular is None else self._regular.constants
        """Of those of a regular joint, if that is another one."""
        # Where the shares are taken: at the regular joint's wires, if they are others.
        self._tensions_in: Callable[[Rotation], _Tensions] = partial(pose_tensions, self.wires)
        self._shares_in: Callable[[Rotation], Quadruple] = partial(
            pose_shares, self.regular or self.wires
        )

    def compile(self) -> None:
        """Have `at` and `shares` compiled, for what is called in every cycle."""
        self._tensions_in = KernelMemory(self.wires).bind(pose_tensions)
        self._shares_in = KernelMemory(self.regular or self.wires).bind(pose_shares)
        home = natural_rotation((0.0, 0.0, 1.0))
        self._tensions_in(home)  # the first call is what compiles
        self._shares_in(home)

    def at(self, rotation: Rotation) -> PoseTensions:
        """Return what tensions do in a pose."""
        tensions = self._tensions_in(rotation)
        if math.isnan(tensions[0][0]):
            self._wires.jacobian(rotation)  # says which wire it is
        if self._regular is None:
            return PoseTensions(*tensions)
        shares = self._shares_in(rotation)
        return PoseTensions(without_tilt(shares, *tensions[1:]), *tensions[1:])

    def shares(self, rotation: Rotation) -> Quadruple:
        """Return the tensions that turn the ring nowhere, as shares of their sum."""
        if self._regular is not None:
            return self.at(rotation).shares
        shares = self._shares_in(rotation)
        if math.isnan(shares[0]):
            self._wires.jacobian(rotation)
        return shares

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
        balance = self._balance(rotation, load)
        first, second, third, fourth = (
            tension + total * share for tension, share in zip(balance, shares, strict=True)
        )
        return raised((first, second, third, fourth), shares, least)

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

    def _balance(self, rotation: Rotation, load: Vector) -> Quadruple:
        """Return tensions of sum 0 that balance the tilting part of a load, N."""
        if load == _NO_LOAD:
            return (0.0, 0.0, 0.0, 0.0)
        rows = self._wires.jacobian(rotation)
        (ax, ay), (bx, by), (x, y) = (
            (
                sum(p * row[0] for p, row in zip(vector, rotation, strict=True)),
                sum(p * row[1] for p, row in zip(vector, rotation, strict=True)),
            )
            for vector in (
                *(
                    tuple(0.5 * (a - b) for a, b in zip(rows[one], rows[other], strict=True))
                    for one, other in PAIRS
                ),
                load,
            )
        )
        half = 0.5 / (ax * by - ay * bx)
        tensions = [0.0, 0.0, 0.0, 0.0]
        for (one, other), force in zip(
            PAIRS, (half * (x * by - y * bx), half * (ax * y - ay * x)), strict=True
        ):
            tensions[one] = force
            tensions[other] = -force
        return tensions[0], tensions[1], tensions[2], tensions[3]


@inlined
def _triple(a: Vector, b: Vector, c: Vector) -> float:
    """Return ``a . (b x c)``."""
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
