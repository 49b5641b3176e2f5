"""What the loop follows, and the stretches of it that metrics look at."""

from typing import NamedTuple, Protocol, TypeVar

Followed = TypeVar("Followed", covariant=True)


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


class Motion(Protocol[Followed]):
    """A desired motion, from rest to rest."""

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        ...

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The stretches that metrics look at."""
        ...

    def at(self, t: float) -> Followed:
        """Return the reference at `t` seconds, 0 … `duration`."""
        ...
