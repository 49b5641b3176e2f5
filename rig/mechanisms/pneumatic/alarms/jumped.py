"""Whether a pressure monitor says from one cycle to the next what no air can have done."""

from collections.abc import Sequence
from typing import Final, NamedTuple

_ALONE: Final = 0.25
"""Air that moves goes on to: the cycles beside a jump may go by this share of it."""
_AFTER: Final = 2
"""So many cycles after it a monitor is to stay where it has jumped to: a spike does not."""
_LATE: Final = 1.5
"""A cycle that takes so many times the last one has missed something of the pressures."""
_PASSED_OVER = 3.5
"""In a stop it may take so long: what is read more seldom, as of a module that has stopped, falls
by leaps."""


class Jump(NamedTuple):
    """A jump that a monitor has made.

    Parameters
    ----------
    number : int
        Of the monitor.
    by : float
        How far, Pa.
    is_away : bool
        Whether it went away from a healthy pressure.
    """

    number: int
    by: float
    is_away: bool


class JumpedMonitors:
    """Tells the monitor that jumps within a cycle, and stays there.

    A connector that slips or a supply of the amplifier that breaks down does that; a chamber that
    is fed, vented or torn open moves for several cycles. A loop that is closed over the monitor
    (a valve) makes up for the jump at once, and is then blind for how much air there is: nothing
    but the jump itself gives it away.

    Parameters
    ----------
    least : float
        Smaller jumps are not looked at, Pa.
    """

    def __init__(self, least: float) -> None:
        self._least = least
        self._is_stopping, self._unread = False, 0.0
        self._shown: Sequence[float] = ()
        self._step: float
        self._goes_on: bool
        self._ways: list[float]
        self._jumps: list[Jump | None]
        self._stayed: list[int]
        self._last: tuple[float, ...] = ()

    def follow_stop(self) -> None:
        """Look at a safe stop from now on: what is `off` are the pressures themselves.

        Nothing can be tripped any more: a cycle or two that missed something are passed over.
        """
        self._is_stopping, self._last = True, tuple(self._shown)

    def find(self, off: Sequence[float], shown: Sequence[float], step: float) -> Jump | None:
        """Take what a cycle reads; return the jump that a monitor has made, if one has.

        Parameters
        ----------
        off : sequence of float
            How far the monitors are off healthy pressures, Pa.
        shown : sequence of float
            What they say, Pa: the same of all of them is that of a frame which was lost.
        step : float
            Since the cycle before, s.
        """
        is_read, self._shown = shown != self._shown, shown
        if self._is_stopping and not is_read:
            self._unread += step
            return None
        last, self._last = self._last, tuple(off)
        since, self._unread = step + self._unread, 0.0
        most = _PASSED_OVER if self._is_stopping else _LATE
        if not last or since > most * self._step or not is_read:
            self._restart(len(off), step)
            return None
        goes_on, self._goes_on, self._step = self._goes_on, True, step
        found = None
        for k, (here, before) in enumerate(zip(off, last, strict=True)):
            way, way_before, self._ways[k] = here - before, self._ways[k], here - before
            jump = self._jumps[k]
            if jump is not None:
                if abs(way) <= _ALONE * abs(jump.by):
                    self._stayed[k] += 1
                    if self._stayed[k] >= _AFTER:
                        self._jumps[k], found = None, jump
                    continue
                self._jumps[k] = None  # what has not stayed may have been the first of a larger one
            if abs(way) > self._least and goes_on and abs(way_before) <= _ALONE * abs(way):
                self._jumps[k], self._stayed[k] = Jump(k, way, abs(here) > abs(before)), 0
        return found

    def _restart(self, count: int, step: float) -> None:
        """Look for no jump in this cycle, nor in the next, which may make up for it."""
        self._step = step
        self._goes_on = False
        self._ways = [0.0] * count
        self._jumps = [None] * count
        self._stayed = [0] * count
