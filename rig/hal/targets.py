"""Where a mechanism may be sent by numbers: what a plan written in Python needs of it."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Protocol, TypeVar

Reference = TypeVar("Reference")


class Targets(Protocol[Reference]):
    """The places and motions that a mechanism can be asked for by numbers."""

    words: str
    """What the numbers of a target are, for messages: names and units."""

    @abstractmethod
    def rest(self, target: Sequence[float]) -> Reference:
        """Return the reference to rest at a target; ValueError if it is none."""

    @abstractmethod
    def moving(
        self, before: Reference, here: Reference, after: Reference, step: float
    ) -> Reference:
        """Return the reference of a motion through three rests that are `step` seconds apart."""

    @abstractmethod
    def distance(self, one: Reference, other: Reference) -> float:
        """Return how far two rests are apart, in the unit of a target."""

    @abstractmethod
    def check(self, reference: Reference) -> None:
        """Raise ValueError, with number and bound, if the rig must not be there or move so."""
