"""What the loop follows, and the stretches of it that metrics look at."""

from collections.abc import Mapping
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


class Fact(NamedTuple):
    """A number that is known of a motion before it is done: it may be a metric like a measured one.

    Parameters
    ----------
    value : float
        SI.
    unit : str
        SI unit, empty for a ratio.
    description : str
        For reports.
    """

    value: float
    unit: str
    description: str


def facts_of(motion: "Motion[object]") -> Mapping[str, Fact]:
    """Return what is known of a motion before it is done; empty for one that was only drawn."""
    facts: Mapping[str, Fact] = getattr(motion, "facts", {})
    return facts
