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
    a, b, c3 = (tuple(dot(row, column) for column in columns) for row in turn)
    return a, b, c3  # type: ignore[return-value]


def rotation_error(wanted: Rotation, actual: Rotation) -> Vector:
    """Return the rotation vector (rad, small angles) that turns `actual` into `wanted`."""
    (a00, a01, a02), (a10, a11, a12), (a20, a21, a22) = actual
    (w00, w01, w02), (w10, w11, w12), (w20, w21, w22) = wanted
    # Half the sum of the cross products of the columns.
    return (
        0.5 * (a10 * w20 - a20 * w10 + a11 * w21 - a21 * w11 + a12 * w22 - a22 * w12),
        0.5 * (a20 * w00 - a00 * w20 + a21 * w01 - a01 * w21 + a22 * w02 - a02 * w22),
        0.5 * (a00 * w10 - a10 * w00 + a01 * w11 - a11 * w01 + a02 * w12 - a12 * w02),
    )
