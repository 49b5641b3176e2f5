"""Absolute deadlines: a cycle that comes late skips ticks; it never bursts to catch up.

The program judges its own lateness before it judges a device: whoever was not asked in time cannot
have answered.
"""

import math
from collections.abc import Callable
from typing import Any

from rig.hal import DeviceError, LoopStalled, StaleReading
from rig.runtime.phases import Events, Phases

_NOTICED = 2
"""Ticks missed by which a device may have tripped: its watchdogs are longer than two periods."""


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
    lost : float
        Time that the program lost right before this cycle, s; 0 unless it missed a tick.
    stall : LoopStalled or None
        The pause that this cycle wakes from, if it was too long.
    """

    def __init__(
        self, run: Phases[Any, Any, Any], period: float, max_missed: int, events: Events
    ) -> None:
        self.tick = 0
        self.lost: float
        self.stall: LoopStalled | None = None
        self._run = run
        self._period = period
        self._max_missed = max_missed
        self._events = events
        self._skipped = 0
        self._in_a_row = 0
        self._woke: tuple[float, float]  # when this cycle began and how late, s
        # The last one that a device may have noticed: the tick after it, and its length, s.
        self._pause: tuple[int, float] | None = None

    def wake(self, t: float) -> None:
        """Judge how late a cycle begins, before anything is read. Hot path.

        Parameters
        ----------
        t : float
            When it begins, s since the first.
        """
        late = t - self.tick * self._period
        self._woke = (t, late)
        self.lost = self._skipped * self._period
        if late < self._period:
            return
        self.lost += late
        missed = math.ceil((late - self._period) / self._period)
        if self._in_a_row + missed > self._max_missed:
            self.stall = self._miss(t, missed, late, late)

    def advance(self, t: float, now: float, busiest: Callable[[], str]) -> float:
        """Return when the next cycle is due.

        Parameters
        ----------
        t : float
            When this cycle began, s since the first.
        now : float
            When its work was done, s since the first.
        busiest : callable
            Returns the step that took most of the work.

        Raises
        ------
        LoopStalled
            Too many ticks in a row were missed.
        """
        self.tick += 1
        late_by = now - self.tick * self._period
        if late_by <= 0.0:
            self._skipped = self._in_a_row = 0
            return self.tick * self._period
        skipped = self._skipped = math.ceil(late_by / self._period)
        asleep = t - (self.tick - 1) * self._period
        place = "" if asleep > now - t else f" in its own work, mostly in {busiest()}"
        stall = self._miss(t, skipped, late_by, max(asleep, now - t), place)
        self.tick += skipped
        if skipped >= _NOTICED:
            self._pause = (self.tick, late_by)
        if stall is not None:
            raise stall
        return self.tick * self._period

    def blame(self, error: Exception) -> Exception:
        """Return a device's error as the program's own if the program was paused right before."""
        now = self.lost if self.lost >= _NOTICED * self._period else 0.0
        pause = max(now, self._recent_pause())
        if not isinstance(error, DeviceError | StaleReading) or not pause:
            return error
        t, late = self._woke
        missed = math.floor(late / self._period)
        if now and missed > 0:  # this cycle is the last: nobody else counts them
            self._miss(t, missed, late, late)
        return LoopStalled(f"the program was paused for {pause * 1e3:.1f} ms, and then {error}")

    def _recent_pause(self) -> float:
        """Return the last pause that a device may still suffer from, s; 0: there is none."""
        if self._pause is None:
            return 0.0
        after, length = self._pause
        return length if self.tick - after <= self._max_missed else 0.0

    def _miss(
        self, t: float, skipped: int, late_by: float, pause: float, place: str = ""
    ) -> LoopStalled | None:
        """Count ticks that are missed and tell of them; return the fault if they are too many."""
        self._run.missed += skipped
        self._in_a_row += skipped
        self._events(t, "overrun", f"{skipped} ticks missed", {"late": late_by})
        if self._in_a_row <= self._max_missed:
            return None
        return LoopStalled(
            f"the program was paused for {pause * 1e3:.1f} ms{place}: {self._in_a_row} ticks of "
            f"{self._period * 1e3:g} ms missed in a row, at most {self._max_missed} are allowed"
        )
