"""The progress line of a run: one line on a terminal, a few lines in a pipe."""

import contextlib
import sys
from pathlib import Path
from time import monotonic

from rig.cli.terminal_line import TerminalLine
from rig.experiment.watcher import Watcher
from rig.runtime.loop import Progress
from rig.runtime.phases import Phase

_REDRAW = 0.1
"""Least time between two redraws, s of wall clock."""

_NAMES = {Phase.APPROACH: "approach", Phase.RUN: "run", Phase.STOP: "stop"}


class ProgressLine(TerminalLine, Watcher):
    """Shows phase, time, speed and worst margin on stderr.

    In a pipe only phases are told.

    Parameters
    ----------
    experiment, backend : str
        What is run on what.
    """

    def __init__(self, experiment: str, backend: str) -> None:
        super().__init__()
        self._title = f"{experiment} on {backend}"
        self._drawn_at = 0.0
        self._phase: Phase | None = None
        self._began: tuple[float, float] | None = None

    def started(self, path: Path) -> None:
        """Say where the run is recorded."""
        self._tell(f"{self._title}: recording to {path}")

    def said(self, sentence: str) -> None:
        """Pass a sentence on."""
        self._tell(sentence)

    def working(self, what: str) -> None:
        """Say what is waited for; on a terminal until it is done."""
        if self.is_seen:
            self.draw(f"{what} …")
        else:
            self._tell(f"{what} …")

    def progressed(self, progress: Progress) -> None:
        """Redraw the line if it is time to."""
        now = monotonic()
        if self._began is None:
            self._began = (now, progress.t)
        if not self.is_seen:
            if progress.phase is not self._phase:
                self._tell(f"{_NAMES[progress.phase]} …")
            self._phase = progress.phase
            return
        if now - self._drawn_at < _REDRAW:
            return
        self._drawn_at = now
        began, t = self._began
        speed = (progress.t - t) / (now - began) if now > began else 0.0
        share = min(max(progress.t / progress.duration, 0.0), 1.0) if progress.duration else 1.0
        bar = "█" * round(20 * share) + "░" * (20 - round(20 * share))
        missed = f"  missed {progress.missed}" if progress.missed else ""
        self.draw(
            f"{_NAMES[progress.phase]:8} {bar} {progress.t:6.1f}/{progress.duration:.1f} s of the "
            f"reference  {speed:5.1f}x  margin {100 * progress.margin.fraction:3.0f} % "
            f"({progress.margin.name}){missed}"
        )

    def _tell(self, text: str) -> None:
        self.draw("")
        with contextlib.suppress(OSError):  # nobody reads it any more: no reason to stop a rig
            print(text, file=sys.stderr, flush=True)  # noqa: T201 - the operator's terminal
