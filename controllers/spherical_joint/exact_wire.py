"""The wires as they are: taut, without friction, around the ball or free of it.

The ring's anchors lie on the ball, so a wire that touches it follows a great circle from its
anchor to the tangent point, in the plane of anchor, adjust point and centre, and goes on straight.
With psi the angle between anchor A and adjust point B seen from the centre, t_b the length of the
tangent from B and psi_w its angle,

    l = t_b + r_c (psi - psi_w)     where psi > psi_w (wound),
    l = |A - B|                     elsewhere (free),

which meet with equal slopes: r_c sin(psi) b / l at psi_w, where |A - B| = t_b, is r_c.
"""

import math
from dataclasses import dataclass

from controllers.compiled import PlainNumbers, inlined
from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry, Vectors
from controllers.spherical_joint.poses import Rotation, Vector, rotate

_LEAST = 1e-18
"""Sine squared of the least angle between anchor and adjust point, over ratios near 1."""

_VANISHING = 5e-8
"""Over the ball's radius cubed. Nearer to a pose in which no wire spins the ring, rounding would be
more than what the limit of the shares is off."""


@dataclass(frozen=True)
class WireConstants(PlainNumbers):
    """The numbers of the wires, for Python and for kernels.

    Parameters
    ----------
    radius : float
        r_c, m.
    wound_from : float
        psi_w, rad.
    straight : float
        t_b - r_c psi_w, m.
    squares : float
        r_c² + b², m².
    vanishing : float
        Below which the wires hardly spin the ring together, m³.
    anchors, adjusts : tuple of tuple of float
        Anchors at home and adjust points, m.
    """

    radius: float
    wound_from: float
    straight: float
    squares: float
    vanishing: float
    anchors: Vectors
    adjusts: Vectors


@inlined
def _vector(vectors: Vectors, wire: int) -> Vector:
    x, y, z = vectors[wire][0], vectors[wire][1], vectors[wire][2]
    return x, y, z


@inlined
def wire_lengths(wires: WireConstants, rotation: Rotation) -> Quadruple:
    """Return the lengths from anchor to adjust point, m; see `ExactWires.lengths`."""
    return (
        _length(wires, rotation, 0),
        _length(wires, rotation, 1),
        _length(wires, rotation, 2),
        _length(wires, rotation, 3),
    )


@inlined
def _length(wires: WireConstants, rotation: Rotation, wire: int) -> float:
    x, y, z = rotate(rotation, _vector(wires.anchors, wire))
    a, b, c = _vector(wires.adjusts, wire)
    n_x = y * c - z * b
    n_y = z * a - x * c
    n_z = x * b - y * a
    angle = math.atan2(math.sqrt(n_x * n_x + n_y * n_y + n_z * n_z), x * a + y * b + z * c)
    if angle > wires.wound_from:
        return wires.straight + wires.radius * angle
    x -= a
    y -= b
    z -= c
    return math.sqrt(x * x + y * y + z * z)


@inlined
def wire_jacobian(wires: WireConstants, rotation: Rotation) -> Vectors:
    """Return how each length grows with the ring's rotation, m/rad; see `ExactWires.jacobian`.

    The row of a wire that may go either way round the ball is not a number.
    """
    return (
        _row(wires, rotation, 0),
        _row(wires, rotation, 1),
        _row(wires, rotation, 2),
        _row(wires, rotation, 3),
    )


@inlined
def _row(wires: WireConstants, rotation: Rotation, wire: int) -> Vector:
    radius = wires.radius
    x, y, z = rotate(rotation, _vector(wires.anchors, wire))
    a, b, c = _vector(wires.adjusts, wire)
    n_x = y * c - z * b
    n_y = z * a - x * c
    n_z = x * b - y * a
    size = n_x * n_x + n_y * n_y + n_z * n_z
    edge = radius * radius
    if size < _LEAST * edge * edge:
        return (math.nan, math.nan, math.nan)
    # Wound where the angle is beyond psi_w, whose cosine is r_c / |B|.
    along = x * a + y * b + z * c
    share = (
        -radius / math.sqrt(size) if along < edge else -1.0 / math.sqrt(wires.squares - 2.0 * along)
    )
    return (share * n_x, share * n_y, share * n_z)


class ExactWires:
    """Lengths, Jacobian and directions of the four wires."""

    def __init__(self, geometry: SphericalJointGeometry) -> None:
        radius, distance = geometry.ball_radius, geometry.adjust_distance
        tangent = math.sqrt((distance - radius) * (distance + radius))
        # By acos(r/|B|) the angle would be noise of 1e-8 rad where B is close to the ball.
        self.wound_from = wound_from = math.atan2(tangent, radius)
        """psi_w, the angle at the centre beyond which a wire is wound, rad."""
        self.constants = WireConstants(
            radius,
            wound_from,
            tangent - radius * wound_from,
            radius * radius + distance * distance,
            _VANISHING * radius**3,
            geometry.anchors,
            geometry.adjust_points,
        )
        """For the functions of this file."""
        self._wires = tuple(zip(geometry.anchors, geometry.adjust_points, strict=True))

    def lengths(self, rotation: Rotation) -> Quadruple:
        """Return the lengths from anchor to adjust point, m."""
        return wire_lengths(self.constants, rotation)

    def wound_angles(self, rotation: Rotation) -> Quadruple:
        """Return over which angle each wire lies on the ball, rad; negative: it is free of it."""
        angles = []
        for home, adjust in self._wires:
            anchor = rotate(rotation, home)
            angle = math.atan2(_norm(_cross(anchor, adjust)), _dot(anchor, adjust))
            angles.append(angle - self.wound_from)
        first, second, third, fourth = angles
        return first, second, third, fourth

    def jacobian(self, rotation: Rotation) -> Vectors:
        """Return how each length grows with the ring's rotation, m/rad.

        ``dl_i = g_i . d_omega`` with the rotation vector in the base's frame: a wound wire is a
        pulley of radius r_c about the normal of its plane, a free one has the arm of its line.
        The wires' torque on the ring is ``-sum(T_i g_i)``.

        Raises
        ------
        ValueError
            An anchor is opposite its adjust point: the wire may go either way round the ball.
        """
        rows = wire_jacobian(self.constants, rotation)
        for number, row in enumerate(rows, start=1):
            if math.isnan(row[0]):
                raise ValueError(f"wire {number}: its anchor is in line with ball and adjust point")
        return rows

    def directions(self, rotation: Rotation) -> Vectors:
        """Return the unit vectors in which the wires pull at their anchors, in the base."""
        rows = []
        for home, adjust in self._wires:
            anchor = rotate(rotation, home)
            x, y, z = adjust
            along = _dot(anchor, adjust)
            if math.atan2(_norm(_cross(anchor, adjust)), along) > self.wound_from:
                # Along the great circle: the part of B that is at right angles to A.
                share = along / _dot(anchor, anchor)
            else:
                share = 1.0
            pull = (x - share * anchor[0], y - share * anchor[1], z - share * anchor[2])
            scale = 1.0 / _norm(pull)
            rows.append((scale * pull[0], scale * pull[1], scale * pull[2]))
        first, second, third, fourth = rows
        return first, second, third, fourth


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _norm(a: Vector) -> float:
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
