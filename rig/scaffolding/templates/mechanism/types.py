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
    """Angles (rad) and speeds (rad/s) that the drives are told."""

    positions: Vector
    velocities: Vector


class MyRigModel(NamedTuple):
    """The mechanics as the profile has them, for laws: nothing yet."""
