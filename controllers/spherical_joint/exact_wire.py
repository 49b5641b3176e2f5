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

from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.poses import Rotation, Vector, rotate

Vectors = tuple[Vector, Vector, Vector, Vector]


class ExactWires:
    """Lengths, Jacobian and directions of the four wires.

    Parameters
    ----------
    geometry : SphericalJointGeometry
        Dimensions.
    """

    def __init__(self, geometry: SphericalJointGeometry) -> None:
        radius, distance = geometry.ball_radius, geometry.adjust_distance
        self._radius = radius
        self._tangent = math.sqrt((distance - radius) * (distance + radius))
        # By acos(r/|B|) the angle would be noise of 1e-8 rad where B is close to the ball.
        self.wound_from = math.atan2(self._tangent, radius)
        """psi_w, the angle at the centre beyond which a wire is wound, rad."""
        self._squares = radius * radius + distance * distance
        self._straight = self._tangent - radius * self.wound_from
        self._wires = tuple(zip(geometry.anchors, geometry.adjust_points, strict=True))

    def lengths(self, rotation: Rotation) -> Quadruple:
        """Return the lengths from anchor to adjust point, m."""
        (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation
        radius, straight, wound_from = self._radius, self._straight, self.wound_from
        lengths = []
        for (home_x, home_y, home_z), (a, b, c) in self._wires:
            x = r00 * home_x + r01 * home_y + r02 * home_z
            y = r10 * home_x + r11 * home_y + r12 * home_z
            z = r20 * home_x + r21 * home_y + r22 * home_z
            n_x = y * c - z * b
            n_y = z * a - x * c
            n_z = x * b - y * a
            angle = math.atan2(math.sqrt(n_x * n_x + n_y * n_y + n_z * n_z), x * a + y * b + z * c)
            if angle > wound_from:
                lengths.append(straight + radius * angle)
            else:
                x -= a
                y -= b
                z -= c
                lengths.append(math.sqrt(x * x + y * y + z * z))
        first, second, third, fourth = lengths
        return first, second, third, fourth

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
        (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation
        radius, edge, squares = self._radius, self._radius**2, self._squares
        least = 1e-18 * edge * edge
        rows: list[Vector] = []
        for (home_x, home_y, home_z), (a, b, c) in self._wires:
            x = r00 * home_x + r01 * home_y + r02 * home_z
            y = r10 * home_x + r11 * home_y + r12 * home_z
            z = r20 * home_x + r21 * home_y + r22 * home_z
            n_x = y * c - z * b
            n_y = z * a - x * c
            n_z = x * b - y * a
            size = n_x * n_x + n_y * n_y + n_z * n_z
            if size < least:
                raise ValueError(
                    f"wire {len(rows) + 1}: its anchor is in line with ball and adjust point"
                )
            # Wound where the angle is beyond psi_w, whose cosine is r_c / |B|.
            along = x * a + y * b + z * c
            if along < edge:
                share = -radius / math.sqrt(size)
            else:
                share = -1.0 / math.sqrt(squares - 2.0 * along)
            rows.append((share * n_x, share * n_y, share * n_z))
        first, second, third, fourth = rows
        return first, second, third, fourth

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
