"""An orderly stop in the midst of a motion: the reference comes to rest on its own path."""

from collections.abc import Callable
from typing import Generic

from rig.hal.mechanism import Reference


class Braking(Generic[Reference]):
    """A motion whose time runs out evenly.

    The reference stays on the path that was checked beforehand, so that it leaves no limit; and
    it starts with the speed that it has, so that nothing jumps.

    Parameters
    ----------
    slow_down : callable
        `Mechanism.slow_down`: says what a reference is like that is passed more slowly.
    path : callable
        ``path(t)``: the reference at a time of the motion, s.
    start, end : float
        Times of the motion at which braking begins, and after which it has no more path, s.
    duration : float
        How long the reference takes to come to rest, s.
    """

    def __init__(
        self,
        slow_down: Callable[[Reference, float, float], Reference],
        path: Callable[[float], Reference],
        start: float,
        end: float,
        duration: float,
    ) -> None:
        self._slow_down = slow_down
        self._path = path
        self._start = start
        self._end = end
        self._duration = duration

    def at(self, t: float) -> Reference:
        """Return the reference `t` seconds after braking began."""
        duration = self._duration
        share = min(t / duration, 1.0) if duration > 0.0 else 1.0
        # The rate goes from one to nothing as a cubic whose slope is nothing at both ends.
        rate = 1.0 - share * share * (3.0 - 2.0 * share)
        change = -6.0 * share * (1.0 - share) / duration if duration > 0.0 else 0.0
        gone = duration * (share - share**3 + 0.5 * share**4)
        return self._slow_down(self._path(min(self._start + gone, self._end)), rate, change)
