"""Soles seen from above: their corners, how far two are apart, and how high their planes lie."""

import math

from controllers.gait.geometry import LegGeometry
from controllers.gait.turning import Attitude, rotation_of

Corners = list[tuple[float, float]]


def sole_corners(geometry: LegGeometry, foot: tuple[float, ...], attitude: Attitude) -> Corners:
    """Return the corners of a sole seen from above, anticlockwise, m."""
    sole = geometry.sole
    (a, b, _), (c, d, _), _ = rotation_of(attitude)
    rectangle = (
        (-sole.back, -sole.half_width),
        (sole.front, -sole.half_width),
        (sole.front, sole.half_width),
        (-sole.back, sole.half_width),
    )
    return [(foot[0] + a * x + b * y, foot[1] + c * x + d * y) for x, y in rectangle]


def heights_of(at: tuple[float, ...], attitude: Attitude, points: Corners) -> list[float]:
    """Return the height of a sole's plane at points of the ground, m."""
    normal = [row[2] for row in rotation_of(attitude)]
    return [
        at[2] - (normal[0] * (x - at[0]) + normal[1] * (y - at[1])) / normal[2] for x, y in points
    ]


def gap_between(one: Corners, other: Corners) -> float:
    """Return how far two convex shapes are apart along the edge's normal that parts them best, m.

    Negative by how much they overlap. (Separating axes.)
    """
    best = -math.inf
    for first, second in ((one, other), (other, one)):
        for (ax, ay), (bx, by) in zip(first, first[1:] + first[:1], strict=True):
            length = math.hypot(bx - ax, by - ay)
            nx, ny = (by - ay) / length, (ax - bx) / length  # outwards: corners are anticlockwise
            best = max(best, min(nx * (x - ax) + ny * (y - ay) for x, y in second))
    return best
