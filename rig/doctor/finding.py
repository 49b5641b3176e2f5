"""One thing that was looked at, and what to do about it."""

from enum import StrEnum
from typing import NamedTuple


class Verdict(StrEnum):
    """How well a computer suits a rig in one thing."""

    OK = "ok"
    POOR = "poor"
    """It runs, and less well."""
    NO = "no"
    """It does not run on hardware."""


class Finding(NamedTuple):
    """One thing that was looked at.

    Parameters
    ----------
    what : str
        In a few words.
    found : str
        As it is.
    verdict : Verdict
        See there.
    mend : str
        The command that mends it, or a sentence; empty: nothing is to be mended.
    """

    what: str
    found: str
    verdict: Verdict
    mend: str = ""
