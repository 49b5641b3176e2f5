"""One thing that was looked at, and what to do about it."""

from enum import StrEnum
from typing import NamedTuple


class Fitness(StrEnum):
    """The fitness of a computer for a rig, in one thing."""

    OK = "ok"
    POOR = "poor"
    """It runs, and less well."""
    NO = "no"
    """It does not run on hardware."""


class Look(NamedTuple):
    """One thing that was looked at.

    Parameters
    ----------
    what : str
        In a few words.
    found : str
        As it is.
    verdict : Fitness
        See there.
    mend : str
        The command that mends it, or a sentence; empty: nothing is to be mended.
    """

    what: str
    found: str
    verdict: Fitness
    mend: str = ""
