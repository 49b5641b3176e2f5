"""The progress line of a run: one line on a terminal, a few lines in a pipe."""

import contextlib
import os
import sys
from pathlib import Path
from time import monotonic
from types import TracebackType

from rig.experiment.watcher import Watcher
from rig.runtime.loop import Progress
from rig.runtime.phases import Phase

_REDRAW = 0.1
"""Least time between two redraws, s of wall clock."""

_NAMES = {Phase.APPROACH: "approach", Phase.RUN: "run", Phase.STOP: "stop"}


class ProgressLine(Watcher):
    """Shows phase, time, speed and worst margin on stderr.

    On a terminal the line is redrawn through a descriptor that never blocks: a terminal that
    is stopped (Ctrl-S) or slow must not stop the loop. In a pipe only phases are told.

    Parameters
    ----------
    experiment, backend : str
        What is run on what.
    """

    def __init__(self, experiment: str, backend: str) -> None:
        self._title = f"{experiment} on {backend}"
        self._fd: int | None = None
        self._drawn_at = 0.0
        self._phase: Phase | None = None
        self._began: tuple[float, float] | None = None

    def __enter__(self) -> "ProgressLine":
        if sys.stderr.isatty():
            with contextlib.suppress(OSError):
                self._fd = os.open(
                    os.ttyname(sys.stderr.fileno()), os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY
                )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._clear()
        if self._fd is not None:
            os.close(self._fd)
            self._fd = None

    def started(self, path: Path) -> None:
        """Say where the run is recorded."""
        self._tell(f"{self._title}: recording to {path}")

    def said(self, sentence: str) -> None:
        """Pass a sentence on."""
        self._tell(sentence)

    def progressed(self, progress: Progress) -> None:
        """Redraw the line if it is time to."""
        now = monotonic()
        if self._began is None:
            self._began = (now, progress.t)
        if self._fd is None:
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
        self._draw(
            f"{_NAMES[progress.phase]:8} {bar} {progress.t:6.1f}/{progress.duration:.1f} s  "
            f"{speed:5.1f}x  margin {100 * progress.margin.fraction:3.0f} % "
            f"({progress.margin.name}){missed}"
        )

    def _draw(self, text: str) -> None:
        if self._fd is not None:
            with contextlib.suppress(OSError):  # full or gone: the next redraw may get through
                os.write(self._fd, f"\r\x1b[2K{text}".encode())

    def _clear(self) -> None:
        self._draw("")

    def _tell(self, text: str) -> None:
        self._clear()
        with contextlib.suppress(OSError):  # nobody reads it any more: no reason to stop a rig
            print(text, file=sys.stderr, flush=True)  # noqa: T201 - the operator's terminal
