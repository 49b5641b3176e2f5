"""Between pixels and places on the marker's sphere.

The marker moves on a sphere round the joint's centre, so one ray gives all three coordinates
at every tilt. A homography of the image to a plane is right at one tilt only.

All of this runs once per frame on a handful of points: Python floats, no arrays.
"""

from collections.abc import Sequence
from math import atan2, cos, hypot, pi, sin, sqrt
from typing import Final

from drivers.marker_camera.settings import MarkerCameraSettings

Point = tuple[float, float]
Vector3 = tuple[float, float, float]
Matrix3 = tuple[Vector3, Vector3, Vector3]

_UNDISTORT_STEPS: Final = 30
_UNDISTORT_STEP: Final = 1e-13
"""Change of a normalised coordinate at which the distortion is inverted well enough."""


def rotation_from_vector(vector: Vector3) -> Matrix3:
    """Return the rotation matrix of a rotation vector (rad), by Rodrigues' formula."""
    x, y, z = vector
    angle = sqrt(x * x + y * y + z * z)
    if angle == 0.0:
        return ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    x, y, z = x / angle, y / angle, z / angle
    c, s = cos(angle), sin(angle)
    v = 1.0 - c
    return (
        (c + x * x * v, x * y * v - z * s, x * z * v + y * s),
        (y * x * v + z * s, c + y * y * v, y * z * v - x * s),
        (z * x * v - y * s, z * y * v + x * s, c + z * z * v),
    )


class View:
    """A calibrated camera above a joint."""

    def __init__(self, settings: MarkerCameraSettings) -> None:
        self._lens = settings.intrinsics
        self._rotation = rotation_from_vector(settings.rotation_base_from_camera)
        self._centre = settings.position_camera_in_base
        self.sphere_radius = settings.marker.sphere_radius

    # The lens -------------------------------------------------------------------------

    def undistort(self, pixel: Point) -> Point:
        """Return the normalised coordinates (x/z, y/z) that a pixel sees.

        Notes
        -----
        Inverts the distortion model of Brown (1971) by fixed-point iteration, which contracts
        for every lens whose image does not fold over itself.
        """
        lens = self._lens
        x0 = (pixel[0] - lens.cx) / lens.fx
        y0 = (pixel[1] - lens.cy) / lens.fy
        x, y = x0, y0
        for _ in range(_UNDISTORT_STEPS):
            r2 = x * x + y * y
            radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
            next_x = (x0 - 2.0 * lens.p1 * x * y - lens.p2 * (r2 + 2.0 * x * x)) / radial
            next_y = (y0 - lens.p1 * (r2 + 2.0 * y * y) - 2.0 * lens.p2 * x * y) / radial
            step = abs(next_x - x) + abs(next_y - y)
            x, y = next_x, next_y
            if step < _UNDISTORT_STEP:
                break
        return x, y

    def project(self, position: Vector3) -> Point:
        """Return the pixel at which a point of the base frame (m) is seen."""
        lens = self._lens
        x, y, z = self.to_camera(position)
        x, y = x / z, y / z
        r2 = x * x + y * y
        radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
        u = x * radial + 2.0 * lens.p1 * x * y + lens.p2 * (r2 + 2.0 * x * x)
        v = y * radial + lens.p1 * (r2 + 2.0 * y * y) + 2.0 * lens.p2 * x * y
        return lens.fx * u + lens.cx, lens.fy * v + lens.cy

    def to_camera(self, position: Vector3) -> Vector3:
        """Return a point of the base frame in the camera's frame, m."""
        c = self._centre
        return self._turn_back((position[0] - c[0], position[1] - c[1], position[2] - c[2]))

    def _turn_back(self, vector: Vector3) -> Vector3:
        """Return a direction of the base frame in the camera's frame."""
        a, b, c = self._rotation
        x, y, z = vector
        return (
            a[0] * x + b[0] * y + c[0] * z,
            a[1] * x + b[1] * y + c[1] * z,
            a[2] * x + b[2] * y + c[2] * z,
        )

    def ray(self, normalised: Point) -> Vector3:
        """Return the direction of a ray in the base frame, not of unit length."""
        a, b, c = self._rotation
        x, y = normalised
        return (
            a[0] * x + a[1] * y + a[2],
            b[0] * x + b[1] * y + b[2],
            c[0] * x + c[1] * y + c[2],
        )

    # The sphere -----------------------------------------------------------------------

    def meet_sphere(self, normalised: Point) -> Vector3 | None:
        """Return where a ray first meets the marker's sphere, m; None if it passes by."""
        dx, dy, dz = self.ray(normalised)
        cx, cy, cz = self._centre
        length = dx * dx + dy * dy + dz * dz
        along = dx * cx + dy * cy + dz * cz
        beyond = cx * cx + cy * cy + cz * cz - self.sphere_radius**2
        root = along * along - length * beyond
        if root < 0.0:
            return None
        s = (-along - sqrt(root)) / length
        return (cx + s * dx, cy + s * dy, cz + s * dz) if s > 0.0 else None

    def disc_centre_shift(self, position: Vector3, radius: float) -> Point:
        """Return how far a disc's image lies off the image of its centre, normalised.

        The perspective image of a circle is an ellipse whose centre is not the image of the
        circle's centre. With centre C, unit normal n (camera frame) and radius r, the dual conic
        of the image is r² (I - n nᵀ) - C Cᵀ, and the ellipse's centre is its pole of the line at
        infinity.

        Parameters
        ----------
        position : tuple of float
            The disc's centre in the base frame, m; its normal is the sphere's.
        radius : float
            Of the disc, m.

        References
        ----------
        Hartley and Zisserman, Multiple View Geometry, 2nd ed., section 2.2.3 (dual conics) and
        section 2.8.1 (poles).
        """
        h = self.sphere_radius
        nx, ny, nz = self._turn_back((position[0] / h, position[1] / h, position[2] / h))
        x, y, z = self.to_camera(position)
        r2 = radius * radius
        w = z * z - r2 * (1.0 - nz * nz)
        return (x * z + r2 * nx * nz) / w - x / z, (y * z + r2 * ny * nz) / w - y / z

    def disc_area(self, position: Vector3, radius: float) -> float:
        """Return the area of a small disc's image, pixels²; 0 if it shows its back.

        Parameters
        ----------
        position : tuple of float
            Its centre in the base frame, m; its normal is the sphere's.
        radius : float
            m.
        """
        h = self.sphere_radius
        nx, ny, nz = self._turn_back((position[0] / h, position[1] / h, position[2] / h))
        x, y, z = self.to_camera(position)
        facing = -(nx * x + ny * y + nz * z)
        area = pi * radius * radius * self._lens.fx * self._lens.fy * facing / z**3
        return max(area, 0.0)

    def locate_disc(self, pixel: Point, radius: float) -> Vector3 | None:
        """Return the centre of a disc whose image has its centroid at a pixel, m.

        Parameters
        ----------
        pixel : tuple of float
            Centroid of the disc's image.
        radius : float
            Of the disc, m.

        Returns
        -------
        tuple of float or None
            In the base frame; None if the ray passes by the sphere.
        """
        x, y = self.undistort(pixel)
        position = self.meet_sphere((x, y))
        for _ in range(2):  # the shift is some 0.1 px and changes slowly: twice is exact
            if position is None:
                return None
            shift_x, shift_y = self.disc_centre_shift(position, radius)
            position = self.meet_sphere((x - shift_x, y - shift_y))
        return position

    # The tangent plane ----------------------------------------------------------------

    def twist(self, position: Vector3, corners: Sequence[Point]) -> float | None:
        """Return the twist of a square marker, rad.

        Twist is the rotation about the marker's normal that is left after the shortest rotation
        which takes the z axis to the normal: zero for a joint that tilts without spinning, if
        the marker's sides are parallel to the x and y axes at home.

        Parameters
        ----------
        position : tuple of float
            The marker's centre in the base frame, m.
        corners : sequence of tuple of float
            Top left, top right, bottom right and bottom left, undistorted and normalised.

        Returns
        -------
        float or None
            -π … π; None if the marker is seen edge on, or upside down.
        """
        h = self.sphere_radius
        n = (position[0] / h, position[1] / h, position[2] / h)
        down = 1.0 + n[2]
        if down < 1e-9:  # the shortest rotation to the south pole is not unique
            return None
        x_axis = (1.0 - n[0] * n[0] / down, -n[0] * n[1] / down, -n[0])
        y_axis = (-n[0] * n[1] / down, 1.0 - n[1] * n[1] / down, -n[1])
        met = [self._meet_plane(corner, position, n) for corner in corners]
        points = [(_dot(p, x_axis), _dot(p, y_axis)) for p in met if p is not None]
        if len(points) < 4:
            return None
        (x0, y0), (x1, y1), (x2, y2), (x3, y3) = points
        # The rotation that takes both pairs of sides best to where they belong.
        right = (x1 + x2 - x0 - x3, y1 + y2 - y0 - y3)
        up = (x0 + x1 - x2 - x3, y0 + y1 - y2 - y3)
        return atan2(right[1] - up[0], right[0] + up[1])

    def _meet_plane(self, normalised: Point, position: Vector3, normal: Vector3) -> Vector3 | None:
        direction = self.ray(normalised)
        slope = _dot(direction, normal)
        if abs(slope) < 1e-6 * hypot(*direction):
            return None
        c = self._centre
        gap = (position[0] - c[0], position[1] - c[1], position[2] - c[2])
        s = _dot(gap, normal) / slope
        return c[0] + s * direction[0], c[1] + s * direction[1], c[2] + s * direction[2]


def _dot(a: Vector3, b: Vector3) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
