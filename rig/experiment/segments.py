"""A stretch of a reference that a metric looks at."""

from typing import NamedTuple


class Segment(NamedTuple):
    """A named stretch of time, settling already left out.

    Parameters
    ----------
    name : str
        What happens in it, e.g. ``"0.2 Hz"`` or ``"hold +4 mm"``.
    start, end : float
        Seconds since the reference started.
    """

    name: str
    start: float
    end: float
