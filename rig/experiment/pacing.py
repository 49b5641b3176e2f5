"""Keeps a simulation from running away from whoever steers or watches it."""

from time import monotonic, sleep

from rig.experiment.watcher import Watcher
from rig.runtime.loop import Progress

BURST = 0.01
"""A simulation that is held back runs ahead of real time by no more than this, s: who steers it
would not be heard in between."""


class RealTime:
    """Waits until real time has come as far as simulated time.

    Parameters
    ----------
    pace : float
        Times real time that a run goes at most.
    """

    def __init__(self, pace: float) -> None:
        self._pace = pace
        self._origin: float | None = None

    def wait(self, elapsed: float) -> None:
        """Wait if `elapsed` (s since the run began) is ahead of the clock on the wall."""
        now = monotonic()
        if self._origin is None:
            self._origin = now - elapsed / self._pace
        ahead = self._origin + elapsed / self._pace - now
        if ahead > 0.0:
            sleep(ahead)
        else:  # it is never caught up with: what is slow stays slow
            self._origin -= ahead


class PacedWatcher(Watcher):
    """Holds a simulation at a pace, and tells nobody of it.

    Parameters
    ----------
    pace : float
        Times real time that it goes at most.
    """

    progress_every = BURST

    def __init__(self, pace: float) -> None:
        self._time = RealTime(pace)

    def progressed(self, progress: Progress) -> None:
        """Wait for real time where simulated time is ahead of it."""
        self._time.wait(progress.elapsed)
