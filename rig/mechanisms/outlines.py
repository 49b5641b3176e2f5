"""Outlines that the mechanisms' scenes are made of, as points of all rows at once."""

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]


def fixed(points: "ArrayLike", rows: int) -> "Array":
    """Return points that do not move, shape (rows, p, 3)."""
    points = np.asarray(points, float)
    return np.broadcast_to(points, (rows, *points.shape))


def circle(radius: float, points: int, axis: int = 2) -> "Array":
    """Return the points of a circle about the origin, shape (points, 3), m."""
    angle = 2.0 * math.pi * np.arange(points) / points
    flat = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(points)], axis=1)
    return np.roll(flat, axis - 2, axis=1)


def track(x: "Array", y: "Array", z: "Array") -> "Array":
    """Return one moving point from its coordinates of n rows, shape (n, 1, 3)."""
    return np.stack([x, y, z], axis=1)[:, None, :]
