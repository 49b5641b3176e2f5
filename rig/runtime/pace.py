"""Absolute deadlines: a cycle that comes late skips ticks; it never bursts to catch up."""

import math
from collections.abc import Callable
from typing import Any

from rig.hal import LoopStalled
from rig.runtime.phases import Phases

Events = Callable[[float, str, str, dict[str, Any]], None]
"""``events(t, kind, message, data)``."""


class Pace:
    """The ticks of a loop.

    Parameters
    ----------
    run : Phases
        Counts the ticks that were skipped.
    period : float
        s.
    max_missed : int
        So many ticks missed in a row are a fault.
    events : callable
        Is told of every overrun.

    Attributes
    ----------
    tick : int
        Number of the tick that is due.
    """

    def __init__(
        self, run: Phases[Any, Any, Any], period: float, max_missed: int, events: Events
    ) -> None:
        self.tick = 0
        self._run = run
        self._period = period
        self._max_missed = max_missed
        self._events = events
        self._in_a_row = 0

    def advance(self, t: float, now: float) -> float:
        """Return when the next cycle is due.

        Parameters
        ----------
        t : float
            When this cycle began, s since the first.
        now : float
            When its work was done, s since the first.

        Raises
        ------
        LoopStalled
            Too many ticks in a row were missed.
        """
        self.tick += 1
        late_by = now - self.tick * self._period
        if late_by <= 0.0:
            self._in_a_row = 0
            return self.tick * self._period
        skipped = math.ceil(late_by / self._period)
        self.tick += skipped
        self._run.missed += skipped
        self._in_a_row += skipped
        self._events(t, "overrun", f"{skipped} ticks missed", {"late": late_by})
        if self._in_a_row > self._max_missed:
            raise LoopStalled(
                f"{self._in_a_row} ticks of {self._period * 1e3:g} ms missed in a row, "
                f"at most {self._max_missed} are allowed"
            )
        return self.tick * self._period
