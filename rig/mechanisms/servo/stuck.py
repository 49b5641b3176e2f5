"""Whether a joint stays where it is while it is sent elsewhere."""

from collections.abc import Sequence
from typing import Final

from rig.hal import LimitExceeded, Vector

_FOLLOWS: Final = 0.25
"""A joint that goes by this share of the way that it is sent is not stuck."""
_SEEN: Final = 0.1
"""Share of the permitted way from which on it may be told whether a joint follows."""
_LATE: Final = 0.05
"""Twice of what a healthy drive and its reading are late by, s: one that is turned round at once
goes on for as long."""


class StandstillWatch:
    """Tells the joint that is sent away and does not go.

    A bound on the distance of a joint from where it was sent has to bear the lag of fast motions
    and the sag under load. What is stuck shows neither: it can be told from a quarter of that
    distance, before legs have carried on with their walk on a joint that does not follow.

    Parameters
    ----------
    names : sequence of str
        Of the joints.
    most : float
        How far a joint may be sent without going along, rad, beside what it is late by.
    """

    def __init__(self, names: Sequence[str], most: float) -> None:
        self._names = tuple(names)
        self._most, self._least = most, _SEEN * most
        self._sent: list[float] = []
        self._stood: list[float]

    def begin(self, positions: Vector) -> None:
        """Take measured positions for those to which the joints were sent, rad."""
        self._sent, self._stood = list(positions), list(positions)

    def check(self, measured: Vector, sent: Vector, speeds: Vector, age: float) -> None:
        """Take a cycle's positions, rad.

        Parameters
        ----------
        measured, sent : tuple of float
            Where the joints are, and where they were sent before, rad.
        speeds : tuple of float
            With which they were sent there, rad/s.
        age : float
            Of the measurements, s.

        Raises
        ------
        LimitExceeded
            A joint does not go; it is named.
        """
        if not self._sent:
            self.begin(measured)
        bases, stood = self._sent, self._stood
        for k, (there, here) in enumerate(zip(sent, measured, strict=True)):
            way = there - bases[k]
            asked = abs(way)
            if asked <= self._least:
                continue
            gone = here - stood[k] if way > 0.0 else stood[k] - here
            if gone >= _FOLLOWS * asked:
                bases[k], stood[k] = there, here
            elif asked - gone > (most := self._most + (_LATE + age) * abs(speeds[k])):
                raise LimitExceeded(
                    f"way that {self._names[k]} was sent and does not go", asked - gone, 0.0, most,
                    "rad",
                )  # fmt: skip
