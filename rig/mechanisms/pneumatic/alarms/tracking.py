"""Tell a loop that swings, or no longer follows, by its rods and by where they should be.

A loop whose gains are too high for its regulators' dead time swings to and fro between the ends
of its pressures. Nothing is broken then, and no reading is wrong: only what was asked for shows it.
"""

import math
from collections import deque
from collections.abc import Sequence

from rig.hal import LimitExceeded, SafetyError
from rig.mechanisms.pneumatic.alarms.settings import OscillationAlarm

_KEPT = 0.7
"""A swing that dies away is below this share of the one before; one that stays is above it."""
_TURN = 0.5
"""The reference turns round if it comes back by this share of the amplitude that counts."""


class _Turns:
    """Finds where a signal turns round, beyond a distance that it has to come back."""

    def __init__(self, distance: float) -> None:
        self._distance = distance
        self._low = self._high = (math.nan, math.nan)  # value and time
        self._rises = True

    def update(self, value: float, now: float) -> tuple[float, float] | None:
        """Take the next value; return an extreme and its time once it is known to be one."""
        if not value <= self._high[0]:
            self._high = (value, now)
        if not value >= self._low[0]:
            self._low = (value, now)
        if self._rises and self._high[0] - value > self._distance:
            self._rises = False
            self._low = (value, now)
            return self._high
        if not self._rises and value - self._low[0] > self._distance:
            self._rises = True
            self._high = (value, now)
            return self._low
        return None


class _Swings:
    """The swings of one rod about its reference since that last turned round."""

    def __init__(self, alarm: OscillationAlarm) -> None:
        self._slowest = alarm.slowest
        self._enough = alarm.swings
        self._error = _Turns(alarm.amplitude)
        self._wanted = _Turns(_TURN * alarm.amplitude)
        self._extreme: float | None = None
        self._turned: deque[float] = deque(maxlen=alarm.swings)
        self.size = math.nan
        """Of the last swing from one extreme to the next, m."""

    def update(self, wanted: float, error: float, now: float) -> float | None:
        """Return the frequency (Hz) of a swing that has lasted; None as long as there is none."""
        if self._wanted.update(wanted, now) is not None:
            self._turned.clear()
        turn = self._error.update(error, now)
        if turn is None:
            return None
        extreme, at = turn
        before, self._extreme = self._extreme, extreme
        if before is None:
            return None
        size, last = abs(extreme - before), self.size
        turned = self._turned
        if size < _KEPT * last or (turned and at - turned[-1] > self._slowest):
            turned.clear()
        self.size = size
        turned.append(at)
        if len(turned) < self._enough:
            return None
        return 0.5 * (len(turned) - 1) / (turned[-1] - turned[0])


class TrackingWatch:
    """Checks how rods follow where they should be while a controller moves them.

    Parameters
    ----------
    names : sequence of str
        Of what moves, for messages: ``the pair``, ``the rod of ch1``.
    following : float
        How far each may be off, m.
    alarm : OscillationAlarm
        For how long, and what is an oscillation.
    """

    def __init__(self, names: Sequence[str], following: float, alarm: OscillationAlarm) -> None:
        self._names = tuple(names)
        self._following = following
        self._alarm = alarm
        self.restart()

    def restart(self) -> None:
        """Forget the past: nothing was controlled."""
        self._swings = [_Swings(self._alarm) for _ in self._names]
        self._followed_at: list[float | None] = [None] * len(self._names)

    def check(self, wanted: Sequence[float], measured: Sequence[float], now: float) -> None:
        """Take a cycle's positions, m, and raise if one swings or does not follow.

        Raises
        ------
        SafetyError
            It oscillates.
        LimitExceeded
            It has been too far off for too long.
        """
        following = self._following
        for k, swings in enumerate(self._swings):
            goal = wanted[k]
            error = measured[k] - goal
            since = self._followed_at[k]
            if -following <= error <= following or since is None:
                self._followed_at[k] = now
            elif now - since > self._alarm.lost:
                what = f"following error of {self._names[k]} for {now - since:.3g} s"
                raise LimitExceeded(what, error, -following, following, "m")
            frequency = swings.update(goal, error, now)
            if frequency is not None:
                raise SafetyError(
                    f"{self._names[k]} oscillates at {frequency:.1f} Hz, {swings.size * 1e3:.2g} "
                    "mm peak to peak, about its reference: the gains are too high for this rig's "
                    "regulators and friction; `rig calibrate` tells their response and dead time "
                    f"[{self._alarm.swings} swings of more than {self._alarm.amplitude * 1e3:g} mm]"
                )
