"""Centre of mass and zero-moment point against the edge of what the feet stand on."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.gait.geometry import LegGeometry
from controllers.gait.leg_postures import leg_posture
from controllers.gait.soles import sole_corners
from controllers.gait.turning import FLAT, Attitude

Array = NDArray[np.float64]

GRAVITY = 9.80665
"""m/s²."""

_LINKS_PER_LEG = 5


class LinkCentres(NamedTuple):
    """Centres of mass.

    Parameters
    ----------
    masses : ndarray, shape (k,)
        kg.
    positions : ndarray, shape (n, k, 3)
        At each of n instants, m.
    """

    masses: Array
    positions: Array

    @property
    def centre(self) -> Array:
        """The centre of mass at each instant, shape (n, 3), m."""
        total: Array = np.einsum("k,nki->ni", self.masses, self.positions) / np.sum(self.masses)
        return total


def link_centres(
    geometry: LegGeometry, q: Array, waist: Array, yaw: Array | None = None
) -> LinkCentres:
    """Return the links' centres under an upright waist.

    Parameters
    ----------
    geometry : LegGeometry
        Lengths and masses.
    q : ndarray, shape (n, 12)
        Joint angles, rad.
    waist : ndarray, shape (n, 3)
        Its position in the ground's frame, m.
    yaw : ndarray, shape (n,), optional
        Its heading, rad; straight ahead if not given.
    """
    m = geometry.masses
    body = np.array((m.upper_body_forward, 0.0, m.upper_body_height))
    masses, seen = [m.upper_body], [np.broadcast_to(body, waist.shape)]
    for leg in (0, 1):
        at = leg_posture(geometry, leg, q)
        masses += [m.hip_yaw + m.hip_roll, m.thigh, m.shank, m.ankle, m.foot]
        seen += [
            at.hip,
            at.hip + m.thigh_centre * geometry.thigh * at.thigh,
            at.knee + m.shank_centre * geometry.shank * at.shank,
            at.ankle,
            at.ankle - m.foot_depth * at.foot[..., 2],
        ]
    positions = np.stack(seen, axis=1)
    if yaw is not None:
        s, c = np.sin(yaw)[:, None], np.cos(yaw)[:, None]
        x, y, z = np.moveaxis(positions, 2, 0)
        positions = np.stack((c * x - s * y, s * x + c * y, z), axis=2)
    return LinkCentres(np.array(masses), waist[:, None] + positions)


def response_samples(period: float, response_time: float) -> int:
    """Return how many periods (s) to either side of an instant its acceleration is taken from."""
    return max(1, round(0.5 * response_time / period))


def zero_moment_point(
    links: LinkCentres, period: float, response_time: float, ground: Array | None = None
) -> Array:
    """Return the point of the ground about which the robot's weight and inertia have no moment.

    The links are point masses. Accelerations are central differences over the response time.

    Parameters
    ----------
    links : LinkCentres
        At instants one period apart; the robot rests before the first and after the last.
    period : float
        s.
    response_time : float
        s.
    ground : ndarray, shape (n,), optional
        Its height at each instant, m; 0 if not given.

    Returns
    -------
    ndarray, shape (n, 2)
        m.

    References
    ----------
    M. Vukobratović, B. Borovac, "Zero-moment point - thirty five years of its life",
    International Journal of Humanoid Robotics 1(1), 2004.
    """
    wide = response_samples(period, response_time)
    padded = np.pad(links.positions, ((wide, wide), (0, 0), (0, 0)), mode="edge")
    middle = padded[wide:-wide]
    acceleration = (padded[2 * wide :] - 2.0 * middle + padded[: -2 * wide]) / (wide * period) ** 2
    lift = links.masses[:, None] * (acceleration[..., 2:] + GRAVITY)
    height = middle[..., 2:] if ground is None else middle[..., 2:] - ground[:, None, None]
    moment = lift * middle[..., :2] - links.masses[:, None] * height * acceleration[..., :2]
    point: Array = np.sum(moment, axis=1) / np.sum(lift, axis=1)
    return point


def standing_knee_torque(geometry: LegGeometry, leg: int, q: Array, waist: Array) -> Array:
    """Return what the knee bears if its leg alone carries the robot at rest, shape (n,), N m.

    Parameters
    ----------
    geometry : LegGeometry
        Lengths and masses.
    leg : int
        That stands: 0 right, 1 left.
    q : ndarray, shape (n, 12)
        Joint angles, rad.
    waist : ndarray, shape (n, 3)
        Its position in the ground's frame, m.
    """
    links = link_centres(geometry, q, waist)
    at = leg_posture(geometry, leg, q)
    below = [_LINKS_PER_LEG * leg + k for k in (3, 4, 5)]  # shank, ankle, foot
    masses = links.masses.copy()
    masses[below] = 0.0
    arms = links.positions - (waist + at.knee)[:, None]
    moment = GRAVITY * np.einsum("k,nki->ni", masses, arms)
    roll = q[:, 6 * leg + 5]
    axis = np.cos(roll)[:, None] * at.foot[..., 1] - np.sin(roll)[:, None] * at.foot[..., 2]
    torque: Array = axis[:, 1] * moment[:, 0] - axis[:, 0] * moment[:, 1]
    return torque


def support_polygon(
    geometry: LegGeometry,
    feet: tuple[tuple[float, ...], ...],
    standing: tuple[bool, bool],
    attitudes: tuple[Attitude, Attitude] = (FLAT, FLAT),
) -> Array:
    """Return the corners of what the robot stands on, anticlockwise.

    Parameters
    ----------
    geometry : LegGeometry
        For the soles.
    feet : tuple of tuple of float
        Where right and left sole are, under the ankle, m.
    standing : tuple of bool
        Which of them bear.
    attitudes : tuple of tuple of float
        Roll, pitch and yaw of the soles, rad.

    Returns
    -------
    ndarray, shape (k, 2)
        The convex hull, m.
    """
    corners = [
        corner
        for foot, stands, attitude in zip(feet, standing, attitudes, strict=True)
        if stands
        for corner in sole_corners(geometry, foot, attitude)
    ]
    return _hull(corners)


def margin(polygon: Array, points: Array) -> Array:
    """Return how far inside a polygon points are, m; negative outside.

    Parameters
    ----------
    polygon : ndarray, shape (k, 2)
        Corners, anticlockwise.
    points : ndarray, shape (n, 2)
        m.
    """
    edges = np.roll(polygon, -1, axis=0) - polygon
    inward = np.column_stack((-edges[:, 1], edges[:, 0]))
    inward /= np.linalg.norm(edges, axis=1)[:, None]
    distances = points @ inward.T - np.sum(polygon * inward, axis=1)
    nearest: Array = np.min(distances, axis=1)
    return nearest


def from_edge(inside: float) -> str:
    """Return a `margin` in words.

    Parameters
    ----------
    inside : float
        m.
    """
    side = "inside" if inside >= 0.0 else "outside"
    return f"{abs(inside) * 1e3:.1f} mm {side} the edge of the support"


def _hull(points: list[tuple[float, float]]) -> Array:
    """Return the convex hull, anticlockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    half: list[list[tuple[float, float]]] = []
    for sequence in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for x, y in sequence:
            while len(chain) >= 2:
                (ax, ay), (bx, by) = chain[-2], chain[-1]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                    break
                chain.pop()
            chain.append((x, y))
        half.append(chain[:-1])
    return np.array(half[0] + half[1])
