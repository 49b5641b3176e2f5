"""The values that pass through the loop; vectors have one element for each of `AXES`."""

from typing import NamedTuple

AXES = ("axis",)
"""More axes are more names here, and as many numbers in every vector."""
Vector = tuple[float, ...]


class MyRigState(NamedTuple):
    """Time (s), angles (rad) and speeds (rad/s) as the drives measure them."""

    t: float
    positions: Vector
    velocities: Vector


class MyRigReference(NamedTuple):
    """Desired angles (rad) and speeds (rad/s); `follow` is for axes that follow a path."""

    positions: Vector
    velocities: Vector
    follow: bool = False


class MyRigCommand(NamedTuple):
    """What the drives are told: angles (rad) and speeds (rad/s)."""

    positions: Vector
    velocities: Vector


class MyRigModel(NamedTuple):
    """What laws are told of the mechanics, of what the profile says: nothing yet."""
