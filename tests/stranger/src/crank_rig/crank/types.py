"""The values that pass through the loop of the crank; vectors are (left, right)."""

from typing import NamedTuple

AXES = ("left", "right")
Pair = tuple[float, float]


class CrankState(NamedTuple):
    """Time (s), angles (rad) and speeds (rad/s) as the drives measure them."""

    t: float
    positions: Pair
    velocities: Pair


class CrankReference(NamedTuple):
    """Desired angles (rad) and speeds (rad/s); a crank follows no path, so `follow` is False."""

    positions: Pair
    velocities: Pair
    follow: bool = False


class CrankCommand(NamedTuple):
    """What the drives are told: angles (rad) and speeds (rad/s)."""

    positions: Pair
    velocities: Pair


class CrankModel(NamedTuple):
    """What the laws are told of the mechanics: the twist at which the rod is unstrained, rad."""

    rod_zero: float
