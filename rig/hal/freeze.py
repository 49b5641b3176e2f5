"""For how long a rig may be left to its last setpoints."""

from typing import NamedTuple


class Freeze(NamedTuple):
    """The longest time that setpoints may stay as they are, and the rig within its limits.

    Parameters
    ----------
    longest : float
        s.
    at : float
        The instant of the motion at which more would be too much, s.
    what : str
        What would pass its limit then; empty if nothing would in the longest time looked at.
    """

    longest: float
    at: float
    what: str
