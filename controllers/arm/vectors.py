"""Vectors and rotations in Python floats."""

import math

from controllers.arm.types import Rotation, Vector


def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def along(origin: Vector, direction: Vector, distance: float) -> Vector:
    """Return the point at a distance from another in a direction."""
    return (
        origin[0] + distance * direction[0],
        origin[1] + distance * direction[1],
        origin[2] + distance * direction[2],
    )


def minus(a: Vector, b: Vector) -> Vector:
    """Return the difference."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scaled(a: Vector, share: float) -> Vector:
    """Return the multiple."""
    return (share * a[0], share * a[1], share * a[2])


def unit(a: Vector, name: str) -> Vector:
    """Return the direction of a vector.

    Raises
    ------
    ValueError
        It has none; `name` says whose.
    """
    length = math.hypot(*a)
    if length == 0.0:
        raise ValueError(f"{name} must have a length: (0, 0, 0) is no direction.")
    return scaled(a, 1.0 / length)


def turned(axis: Vector, angle: float, rotation: Rotation) -> Rotation:
    """Return a rotation turned by an angle (rad) about a unit axis of the base."""
    x, y, z = axis
    s, c = math.sin(angle), math.cos(angle)
    v = 1.0 - c
    turn = (
        (c + v * x * x, v * x * y - s * z, v * x * z + s * y),
        (v * x * y + s * z, c + v * y * y, v * y * z - s * x),
        (v * x * z - s * y, v * y * z + s * x, c + v * z * z),
    )
    columns = tuple(zip(*rotation, strict=True))
    a, b, c3 = (tuple(dot(row, column) for column in columns) for row in turn)  # type: ignore[arg-type]
    return a, b, c3  # type: ignore[return-value]


def rotation_error(wanted: Rotation, actual: Rotation) -> Vector:
    """Return the rotation vector (rad, small angles) that turns `actual` into `wanted`."""
    x = y = z = 0.0
    for j in range(3):
        a = (actual[0][j], actual[1][j], actual[2][j])
        w = (wanted[0][j], wanted[1][j], wanted[2][j])
        x += a[1] * w[2] - a[2] * w[1]
        y += a[2] * w[0] - a[0] * w[2]
        z += a[0] * w[1] - a[1] * w[0]
    return (0.5 * x, 0.5 * y, 0.5 * z)
