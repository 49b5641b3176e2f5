"""Simulated hands that move something to both of its ends, as a person is asked to."""

from math import inf
from typing import Final

from rig.hal import ConfigurationError, HandledPlant
from rig.hal.world import BreakableWorld

_STUCK: Final = 20
"""After so many nudges that move nothing the end is reached."""
_MOVES: Final = 0.2
"""Share of a nudge below which nothing was moved."""


class EndToEnd:
    """A hand that moves one channel up to one end, down to the other, and back.

    Parameters
    ----------
    channel : str
        What the plant calls it.
    column : str
        Of the plant's truth, where it is read as by a gauge; SI.
    nudge : float
        How far each call moves it, SI.
    harder : float
        How many times harder it pulls at last what does not give way, at least 1.
    low, high : float, optional
        The hand goes no further than these, SI; default: to the mechanical ends.

    Attributes
    ----------
    low, high : float
        As given.
    is_back : bool
        Whether it has been at both ends and is back.
    """

    def __init__(
        self,
        channel: str,
        column: str,
        nudge: float,
        harder: float = 1.0,
        low: float = -inf,
        high: float = inf,
    ) -> None:
        self._channel = channel
        self._column = column
        self._nudge = nudge
        self._harder = (harder - 1.0) / _STUCK
        self.low, self.high = low, high
        self._start: float | None = None
        self._goals: list[float] = []
        self._before = inf
        self._stuck = 0
        self.is_back = False
        self._least, self._most = inf, -inf

    def nudge(self, world: BreakableWorld) -> float:
        """Move it on; return how far it has been from end to end so far, SI.

        Raises
        ------
        ConfigurationError
            The plant has nobody who could move it.
        """
        plant = world.plant
        if not isinstance(plant, HandledPlant):
            raise ConfigurationError(f"the simulated plant has nobody to move {self._channel}")
        names = [name for name, _ in plant.truth_columns]
        here = plant.truth()[names.index(self._column)]
        if self._start is None:
            self._start, self._goals = here, [self.high, self.low, here]
        self._least, self._most = min(self._least, here), max(self._most, here)
        moved = abs(here - self._before) > _MOVES * self._nudge
        self._stuck = 0 if moved else self._stuck + 1
        self._before = here
        if self._goals and (self._goals[0] == here or self._stuck >= _STUCK):
            self._goals.pop(0)
            self._stuck = 0
        if self._goals:
            left = self._goals[0] - here
            most = self._nudge * (1.0 + self._harder * self._stuck)
            plant.pull(self._channel, max(min(left, most), -most))
        self.is_back = not self._goals
        return self._most - self._least
