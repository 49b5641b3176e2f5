"""Quantities that a mechanism tells of itself, and how they stand to what is too much."""

from typing import NamedTuple


class Expected(NamedTuple):
    """A quantity that follows from a profile's settings.

    Parameters
    ----------
    name : str
        The quantity, for people.
    value : float
        SI.
    unit : str
        Its unit of SI.
    warning : str
        What is wrong with that value, and which one is not; empty: nothing is.
    """

    name: str
    value: float
    unit: str
    warning: str = ""


class Margin(NamedTuple):
    """The distance of a quantity from its limit: 1 is far, 0 is on it."""

    name: str
    fraction: float
