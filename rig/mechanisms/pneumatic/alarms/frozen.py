"""Whether a pressure monitor repeats one value that its chamber cannot have all the time."""

from collections.abc import Sequence

_LIVELY = 0.5
"""Share of the cycles in which a monitor's value changes by its noise, …"""
_OVER = 0.25
"""… of late, s: one that has no noise, or is read more seldom, is never taken to be frozen."""


class _Monitor:
    """A monitor's value, since when it says that, and a healthy pressure's way meanwhile."""

    __slots__ = ("high", "lively", "low", "since", "value", "was_lively")

    def __init__(self, value: float, healthy: float, now: float) -> None:
        self.value = value
        self.low = self.high = healthy
        self.since = now
        self.lively = self.was_lively = 0.0


class FrozenMonitors:
    """Tells the monitor that has said the very same for too long while its pressure was to move.

    A pressure that nobody moves may be shown by the same number for hours, and a monitor without
    noise repeats it. One whose noise was seen does neither, whatever its chamber does.

    Parameters
    ----------
    time : float
        For which the same value may be said, s.
    moved : float
        By which a healthy pressure has to move meanwhile, Pa.
    least : float
        Up to which a monitor may repeat what it says, Pa: many show nothing else of an empty
        chamber, and go on to do so until air has come.
    """

    def __init__(self, time: float, moved: float, least: float) -> None:
        self._time, self._moved, self._least = time, moved, least
        self._monitors: tuple[_Monitor, ...]
        self._then: float

    def begin(self, shown: Sequence[float], now: float) -> None:
        """Forget the past; `shown` are pressures that are there, Pa."""
        self._monitors = tuple([_Monitor(value, value, now) for value in shown])
        self._then = now

    def find(self, shown: Sequence[float], healthy: Sequence[float], now: float) -> int | None:
        """Take the pressures of a cycle, Pa; return which monitor is frozen, if one is.

        Parameters
        ----------
        shown, healthy : sequence of float
            What the monitors say, and what the pressures should be.
        now : float
            s.
        """
        step = now - self._then
        self._then = now
        share = step / (_OVER + step)
        found = None
        for k, monitor in enumerate(self._monitors):
            value, should = shown[k], healthy[k]
            monitor.lively -= share * monitor.lively
            if value != monitor.value:
                monitor.lively += share
                monitor.value, monitor.since, monitor.was_lively = value, now, monitor.lively
                monitor.low = monitor.high = should
                continue
            monitor.low, monitor.high = min(monitor.low, should), max(monitor.high, should)
            is_long = now - monitor.since > self._time and value > self._least
            if is_long and self.gone(k) > self._moved and monitor.was_lively > _LIVELY:
                found = k
        return found

    def gone(self, k: int) -> float:
        """Return how far a healthy pressure has gone while a monitor has said the same, Pa."""
        return self._monitors[k].high - self._monitors[k].low

    def since(self, k: int) -> float:
        """Return since when a monitor has said the same, s."""
        return self._monitors[k].since
