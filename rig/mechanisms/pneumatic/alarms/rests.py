"""Tell a rod that sticks and slips from one that swings: it stands for most of the time."""

import math
from typing import Final

_STILL: Final = 30e-6
_STILL_FOR: Final = 0.02
"""A rod that goes no farther (m) within this time (s) stands: bristles and wire give by less."""
_MOSTLY: Final = 0.5
"""Share of the time that a rod stands that sticks. A swing of 3 mm in 2 s stands for a fifth."""


class RodRests:
    """The share of the time that one rod has stood of late: the past fades by e in a second."""

    _stands: bool

    def __init__(self) -> None:
        self._place = self._since = self._before = math.nan
        self._stood = self._passed = 0.0

    def update(self, place: float, now: float) -> None:
        """Take a place (m) at a time (s)."""
        passed, self._before = now - self._before, now
        if not abs(place - self._place) <= _STILL:  # nor is the first place any that it had
            self._place, self._since, self._stands = place, now, False
        if math.isnan(passed):
            return
        fades = math.exp(-passed)
        self._stood, self._passed = fades * self._stood, fades * self._passed + passed
        if self._stands:
            self._stood += passed
        elif now - self._since > _STILL_FOR:
            self._stood += now - self._since
            self._stands = True

    @property
    def share(self) -> float:
        """Of the time that it stood."""
        return self._stood / self._passed if self._passed else 0.0

    @property
    def sticks(self) -> bool:
        """Whether it has stood for most of the time."""
        return self.share > _MOSTLY
