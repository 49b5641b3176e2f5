"""The bounds of true values that a rig must not leave, whatever breaks."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

ENERGY_LEFT = "energy left"
"""Name of the hazard that a chamber holds pressure when its rig is said to be safe."""


def _as_it_is(value: float) -> float:
    return value


class Hazard(NamedTuple):
    """A bound of what is true of a plant; beyond it somebody or something may get hurt.

    It is judged by the plant's truth alone, also after the program has ended.

    Parameters
    ----------
    name : str
        What gets too far: ``"position"``.
    unit : str
        Of the bounds, SI.
    columns : sequence of str
        Of `Plant.truth_columns`, each of which is judged.
    low, high : float
        The limit of the profile with the margin that the plant's table states.
    only_safe : bool
        Whether it holds only when the rig says that it is safe, or its program is dead.
    is_rate : bool
        Whether it is the columns' change in time that is bounded.
    of : callable
        What is bounded, of a column's value.
    is_last : bool
        Whether nothing is judged that comes after it, where it is forgiven.
    """

    name: str
    unit: str
    columns: Sequence[str]
    low: float
    high: float
    only_safe: bool = False
    is_rate: bool = False
    of: Callable[[float], float] = _as_it_is
    is_last: bool = False
