"""A measured value with the time at which it was true."""

from typing import Generic, NamedTuple, TypeVar

T = TypeVar("T")


class Reading(NamedTuple, Generic[T]):
    """An immutable measurement.

    Freshness is data: there is no NaN for "nothing yet", and a late value is
    recognised by its age, not by a flag that somebody has to remember to clear.

    Parameters
    ----------
    value : T
        The measured quantity in SI units; a vector is a tuple of floats, one per
        channel, shape ``(n,)``.
    t : float
        When the value was true (sampled, not received), s on the rig's clock.
    """

    value: T
    t: float

    def age(self, now: float) -> float:
        """Return how old the reading is at `now`, s."""
        return now - self.t
