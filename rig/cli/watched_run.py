"""A run with its progress line, and with a page on which it is watched, if that was asked for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep

from rig.cli.progress import ProgressLine
from rig.runtime.loop import Progress


class WatchedRun(ProgressLine):
    """Shows the progress, serves the page, and keeps a simulation from running away.

    The page is served by a process of its own, which reads the run's folder.

    Parameters
    ----------
    experiment, backend : str
        What is run on what.
    pace : float or None
        Times real time that it runs at most; None: as fast as it can.
    watch, steer : bool
        Whether there is a page, and whether gains may be changed on it.
    """

    def __init__(
        self,
        experiment: str,
        backend: str,
        *,
        pace: float | None = None,
        watch: bool = False,
        steer: bool = False,
    ) -> None:
        super().__init__(experiment, backend)
        self._pace, self._watch, self._steer = pace, watch, steer
        self._origin: float | None = None

    def started(self, path: Path) -> None:
        """Say where the run is recorded, and serve its page."""
        super().started(path)
        if self._watch:
            command = [sys.executable, "-m", "rig", "watch", str(path), "--until-left"]
            # A session of its own: Ctrl-C in this terminal is for the run. The page shows its end.
            self._server = subprocess.Popen(
                [*command, *(["--steer"] if self._steer else [])],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                start_new_session=True,
            )

    def progressed(self, progress: Progress) -> None:
        """Redraw the line, and wait for real time where simulated time is ahead of it."""
        super().progressed(progress)
        if self._pace is None:
            return
        now = monotonic()
        if self._origin is None:
            self._origin = now - progress.t / self._pace
        ahead = self._origin + progress.t / self._pace - now
        if ahead > 0.0:
            sleep(ahead)
        else:  # it is never caught up with: what is slow stays slow
            self._origin -= ahead
