"""Whether what the legs feel can be true: what no single device can know of itself."""

import math
from typing import Final

from controllers.gait.sensing import Sensing

_AVERAGED: Final = 0.5
"""s; pushes and landings are shorter."""
_LEAST: Final = 0.6
_MOST: Final = 1.4
"""Share of its weight that a robot may be found to have on its feet."""
_LEAN: Final = math.radians(15.0)
"""No slope that is walked on is steeper, and no robot that leans so far stands, rad."""
_TURN: Final = 0.25
"""A waist that stands turns no faster on the average, rad/s."""


class Suspicion:
    """Compares averages with what must be true of a robot on its feet; once found, it stays.

    Parameters
    ----------
    weight : float
        Of the robot, N.
    period : float
        The loop's, s.
    """

    def __init__(self, weight: float, period: float) -> None:
        self._weight = weight
        self._mix = period / _AVERAGED
        self.reset()

    def reset(self) -> None:
        """Believe again."""
        self.why = ""
        """What cannot be true; empty: nothing was found."""
        self._load = self._weight
        self._means = [0.0, 0.0, 0.0, 0.0]

    def see(self, sensing: Sensing) -> None:
        """Take the measurements of a period."""
        mix, means = self._mix, self._means
        load = sensing.feet[0].force + sensing.feet[1].force
        self._load += mix * (load - self._load)
        for k, value in enumerate((*sensing.lean, *sensing.turning)):
            means[k] += mix * (value - means[k])
        if self.why:
            return
        share = self._load / self._weight
        if not _LEAST <= share <= _MOST:
            self.why = (
                f"the feet bear {self._load:.3g} N of a weight of {self._weight:.3g} N, "
                f"{_LEAST:g} … {_MOST:g} of it are believed"
            )
        elif max(abs(means[0]), abs(means[1])) > _LEAN:
            self.why = (
                f"the waist leans by {math.degrees(max(map(abs, means[:2]))):.3g} deg, "
                f"{math.degrees(_LEAN):g} deg are believed"
            )
        elif max(abs(means[2]), abs(means[3])) > _TURN:
            self.why = (
                f"the waist turns at {max(map(abs, means[2:])):.3g} rad/s on the average, "
                f"{_TURN:g} rad/s are believed"
            )
