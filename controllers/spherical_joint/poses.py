"""The ring's attitude: its axis, and the two conventions that add a spin to it.

The ring has three degrees of freedom, the wires control two: the direction of its axis, a unit
vector ``u``. How far the ring has spun about that axis is a convention:

``natural``
    The ring tilts about a horizontal axis and does not spin: the shortest rotation from +Z to u.
    Four taut wires hold a ring there.
``paper``
    ``R_Y(theta) R_X(phi)``, Kobayashi and Saito, eq. (4). Off the axes it spins the ring, by 1.8
    degrees at 20 degrees of tilt; no four positive tensions hold it there.

Everything is in tuples of floats: on the cycle small arrays cost ten times as much.
"""

import math
from collections.abc import Callable
from typing import Literal

from controllers.compiled import inlined

Vector = tuple[float, float, float]
Rotation = tuple[Vector, Vector, Vector]
"""Rows of a rotation matrix, base from ring."""

PoseConvention = Literal["natural", "paper"]


def axis_from_tilt(tilt: float, azimuth: float) -> Vector:
    """Return the axis that leans by `tilt` towards `azimuth` (rad, from +X to +Y)."""
    lean = math.sin(tilt)
    return (lean * math.cos(azimuth), lean * math.sin(azimuth), math.cos(tilt))


def tilt_of(axis: Vector) -> float:
    """Return how far an axis leans from +Z, rad."""
    return math.atan2(math.hypot(axis[0], axis[1]), axis[2])


def azimuth_of(axis: Vector) -> float:
    """Return where an axis leans to, rad from +X to +Y; 0 for +Z."""
    return math.atan2(axis[1], axis[0])


@inlined
def natural_rotation(axis: Vector) -> Rotation:
    """Return the rotation without spin that brings +Z to `axis`.

    Raises
    ------
    ValueError
        The axis points straight down: every horizontal axis would do.
    """
    x, y, z = axis
    if z <= -1.0 + 1e-12:
        raise ValueError("an axis that points straight down has no natural rotation")
    share = 1.0 / (1.0 + z)
    xy = -x * y * share
    return ((1.0 - x * x * share, xy, x), (xy, 1.0 - y * y * share, y), (-x, -y, z))


def paper_rotation(axis: Vector) -> Rotation:
    """Return ``R_Y(theta) R_X(phi)`` with the given ring axis; eq. (4)."""
    x, y, z = axis
    across = math.hypot(x, z)
    cos_theta, sin_theta = (z / across, x / across) if across > 0.0 else (1.0, 0.0)
    return (
        (cos_theta, -sin_theta * y, x),
        (0.0, across, y),
        (-sin_theta, -cos_theta * y, z),
    )


ROTATIONS: dict[PoseConvention, Callable[[Vector], Rotation]] = {
    "natural": natural_rotation,
    "paper": paper_rotation,
}
"""Ring axis to rotation, by the name of the convention."""


def twist_of(rotation: Rotation) -> float:
    """Return the spin of a rotation about its own axis beyond the natural pose, rad."""
    natural = natural_rotation((rotation[0][2], rotation[1][2], rotation[2][2]))
    # Where the ring's own X went, in terms of the natural ring's X and Y.
    along = sum(natural[k][0] * rotation[k][0] for k in range(3))
    across = sum(natural[k][1] * rotation[k][0] for k in range(3))
    return math.atan2(across, along)


@inlined
def move_axis(axis: Vector, velocity: Vector, acceleration: Vector, dt: float) -> Vector:
    """Return where an axis is after `dt` (s) at constant acceleration, as a unit vector."""
    half = 0.5 * dt * dt
    x = axis[0] + dt * velocity[0] + half * acceleration[0]
    y = axis[1] + dt * velocity[1] + half * acceleration[1]
    z = axis[2] + dt * velocity[2] + half * acceleration[2]
    scale = 1.0 / math.sqrt(x * x + y * y + z * z)
    return (scale * x, scale * y, scale * z)


@inlined
def rotate(rotation: Rotation, vector: Vector) -> Vector:
    """Return a vector of the ring in the base's frame."""
    x, y, z = vector
    first, second, third = rotation
    return (
        first[0] * x + first[1] * y + first[2] * z,
        second[0] * x + second[1] * y + second[2] * z,
        third[0] * x + third[1] * y + third[2] * z,
    )
