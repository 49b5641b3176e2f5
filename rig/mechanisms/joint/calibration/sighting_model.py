"""A model of what encoders and camera show, for a joint that is nearly the drawing's.

The wires are those of `controllers.spherical_joint.exact_wire`, for many poses at once. Anchors
and adjust points may each be a little off their circles, since no part is made exactly. The
camera's ray ends on the marker's sphere. There the ring's axis is known, and from the axis the
rods.
"""

from typing import NamedTuple

import numpy as np

from rig.calibration.arrays import Array, Indices
from rig.mechanisms.joint.calibration.parameters import PARTS, WIRES, Values

_STEP = 1e-3
"""Over which a slope is taken, rad."""


class Sightings(NamedTuple):
    """Frames of a camera with what the rods did meanwhile; n frames.

    Parameters
    ----------
    rays : ndarray, shape (n, 3)
        To the marker, in the camera's frame, undistorted; z is 1.
    rods, speeds : ndarray, shape (n, 4)
        Extension of each rod and its shortening's rate in the middle of the exposure, as far as
        its time is known, m and m/s.
    pulls : ndarray, shape (n, 4)
        Of the chambers then, N.
    senses : ndarray, shape (n, 4)
        Friction of the seals over their Coulomb friction at base pressure: positive while a rod
        pulls in, more than 1 while it is slow.
    turns : ndarray, shape (n, 4)
        How those grow with the logarithm of the way over which friction turns round.
    falls : ndarray, shape (n, 4)
        How they grow with the share by which breakaway exceeds Coulomb friction more than believed.
    loads : ndarray, shape (n, 4)
        What friction grows by over its growth with the pull, which does not fall with speed, N.
    blocks : ndarray of int, shape (n,)
        Stretch of the recording that each frame is from.
    t : ndarray, shape (n,)
        When that was, s.
    late : float
        By how much the camera's stamps were taken to be too late for that, s.
    """

    rays: Array
    rods: Array
    speeds: Array
    pulls: Array
    senses: Array
    turns: Array
    falls: Array
    loads: Array
    blocks: Indices
    t: Array
    late: float = 0.0


class WireEnds(NamedTuple):
    """The ends of a joint's wires, and the ball that they are wound on; m.

    Parameters
    ----------
    anchors, adjusts : ndarray, shape (4, 3)
        On the ring upright, and on the base.
    ball : float
        Radius of the ball.
    """

    anchors: Array
    adjusts: Array
    ball: float

    @classmethod
    def of(cls, values: Values) -> "WireEnds":
        """Return the wires of a joint with these dimensions."""
        ball, ring = values["ball_radius"], values["ring_radius"]
        parts = np.array([[values[f"{part}_{k}"] for part in PARTS] for k in WIRES])
        angle = np.array([values[f"anchor_angle_{k}"] for k in WIRES])
        azimuth = angle + parts[:, 0] / ring
        colatitude = np.arcsin(ring / ball) - parts[:, 1] / ball
        sine = np.sin(colatitude)
        anchors = ball * np.column_stack(
            [sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(colatitude)]
        )
        radius, depth = values["adjust_radius"], values["adjust_depth"]
        adjusts = parts[:, 2:] + np.column_stack(
            [radius * np.cos(angle), radius * np.sin(angle), np.full(len(angle), -depth)]
        )
        return cls(anchors, adjusts, ball)

    def lengths(self, axes: Array, twist: float = 0.0) -> Array:
        """Return the length of each wire for axes of shape (n, 3), m, shape (n, 4).

        Parameters
        ----------
        axes : ndarray, shape (n, 3)
            Of the ring, unit vectors.
        twist : float
            Of the ring about its axis beyond the natural pose, rad.
        """
        cos, sin = np.cos(twist), np.sin(twist)
        a = self.anchors
        turned = np.column_stack([cos * a[:, 0] - sin * a[:, 1], sin * a[:, 0] + cos * a[:, 1]])
        x, y, z = axes.T[:, :, None]
        share = (x * turned[:, 0] + y * turned[:, 1]) / (1.0 + z)
        height = a[:, 2]
        # The natural rotation of (a_x, a_y, a_z): what leans goes down, the rest stays.
        px = turned[:, 0] - share * x + height * x
        py = turned[:, 1] - share * y + height * y
        pz = height * z - x * turned[:, 0] - y * turned[:, 1]
        bx, by, bz = self.adjusts.T
        along = px * bx + py * by + pz * bz
        nx, ny, nz = py * bz - pz * by, pz * bx - px * bz, px * by - py * bx
        angle = np.arctan2(np.sqrt(nx * nx + ny * ny + nz * nz), along)
        tangent = np.sqrt(bx * bx + by * by + bz * bz - self.ball**2)
        wound = angle - np.arctan2(tangent, self.ball)
        straight = np.sqrt((px - bx) ** 2 + (py - by) ** 2 + (pz - bz) ** 2)
        return np.asarray(np.where(wound > 0.0, tangent + self.ball * wound, straight))


def rotation(vector: Array) -> Array:
    """Return the matrix of a rotation vector, rad."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(vector).as_matrix())


def camera_pose(values: Values, mounted: Array) -> tuple[Array, Array]:
    """Return orientation and place of the camera in the base.

    Parameters
    ----------
    values : Values
        With the angles by which the camera is turned in its own axes.
    mounted : ndarray, shape (3,)
        Rotation vector of the drawing, rad.
    """
    turn = np.array([values[f"camera_angle_{axis}"] for axis in "xyz"])
    place = np.array([values[f"camera_{axis}"] for axis in "xyz"])
    return rotation(mounted) @ rotation(turn), place


def axes_seen(values: Values, rays: Array, mounted: Array) -> Array:
    """Return the ring's axis that each ray shows, shape (n, 3).

    A ray that passes by the marker's sphere shows the nearest axis: an estimate under way may be
    that far off.
    """
    turn, place = camera_pose(values, mounted)
    ray = rays @ turn.T
    ray /= np.linalg.norm(ray, axis=1)[:, None]
    height = values["marker_height"]
    along = ray @ place
    root = along * along - float(place @ place) + height * height
    met = place + (-along - np.sqrt(np.maximum(root, 0.0)))[:, None] * ray
    axes = met / np.linalg.norm(met, axis=1)[:, None]
    # The marker is beside the ring's axis by a little, along the ring's own x and y.
    off_x, off_y = values["marker_x"] / height, values["marker_y"] / height
    x, y, z = axes.T
    lean = (off_x * x + off_y * y) / (1.0 + z)
    axes = axes - np.column_stack([off_x - lean * x, off_y - lean * y, -off_x * x - off_y * y])
    return np.asarray(axes / np.linalg.norm(axes, axis=1)[:, None])


def extensions_seen(values: Values, seen: Sightings, mounted: Array) -> Array:
    """Return the extension that each rod's encoder shows at each frame, m, shape (n, 4)."""
    wires = WireEnds.of(values)
    upright = wires.lengths(np.array([[0.0, 0.0, 1.0]]))
    friction = np.array([values[f"friction_{k}"] for k in WIRES])
    offset = np.array([values[f"offset_{k}"] for k in WIRES])
    shortening = upright - wires.lengths(axes_seen(values, seen.rays, mounted))
    senses = seen.senses + values["reversal"] * seen.turns + values["excess"] * seen.falls
    lost = friction * senses + values["load"] * seen.loads + values["viscous"] * seen.speeds
    stretch = values["compliance"] * (seen.pulls - lost)
    # The frame shows the ring of another instant; the rods have moved since.
    moved = (values["lateness"] - seen.late) * seen.speeds
    return np.asarray(values["home"] - shortening - stretch + offset - moved)


def rod_slopes(values: Values, seen: Sightings, mounted: Array) -> tuple[Array, ...]:
    """Return how each rod moves with the ring: two directions of its axis and its twist.

    Returns
    -------
    tuple of ndarray, shape (n, 4)
        Per radian, m.
    """
    wires, axes = WireEnds.of(values), axes_seen(values, seen.rays, mounted)
    aside = np.cross(axes, (0.0, 1.0, 0.0))
    aside /= np.linalg.norm(aside, axis=1)[:, None]
    slopes = [
        wires.lengths(axes + _STEP * way) - wires.lengths(axes - _STEP * way)
        for way in (aside, np.cross(axes, aside))
    ]
    slopes.append(wires.lengths(axes, _STEP) - wires.lengths(axes, -_STEP))
    return tuple(slope / (2.0 * _STEP) for slope in slopes)
