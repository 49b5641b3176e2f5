"""The progress of a sweep: one line on a terminal, a few lines in a pipe."""

import contextlib
import sys
from time import monotonic

from rig.sweeping.finding import DONE, PointFinding
from rig.terminals import is_terminal

_REDRAW = 0.2
"""Least time between two redraws, s."""
_SAID_FAILURES = 5
"""So many failures are told as they come; the table has all."""


class SweepProgress:
    """Counts points, and shows them on stderr.

    Parameters
    ----------
    total : int
        All points of the sweep.
    quiet : bool
        Count only.
    """

    def __init__(self, total: int, *, quiet: bool = False) -> None:
        self.total, self.done, self.failed = total, 0, 0
        self._quiet = quiet
        self._known = 0
        self._began = monotonic()
        self._drawn = 0.0
        self._line = not quiet and is_terminal(sys.stderr)
        self._next_tenth = 1

    def known(self) -> None:
        """Count a point that was finished before."""
        self._known += 1
        self.done += 1

    def told(self, finding: PointFinding) -> None:
        """Count a point, and tell of the first ones that fail."""
        self.done += 1
        if finding["status"] not in DONE:
            self.failed += 1
            if self.failed <= _SAID_FAILURES:
                self.say(f"{finding['point'][:8]}: {finding['status']}: {finding['reason']}")

    def show(self, running: int) -> None:
        """Show how far it is, if it is time to."""
        now = monotonic()
        if self._quiet:
            return
        if self._line:
            if now - self._drawn >= _REDRAW:
                self._drawn = now
                self._write(f"\r\x1b[2K{self.text(running)}")
        elif 10 * self.done >= self._next_tenth * self.total:
            self._next_tenth = 10 * self.done // max(self.total, 1) + 1
            self.say(self.text(running))

    def text(self, running: int) -> str:
        """Return how far it is."""
        new = self.done - self._known
        rate = new / max(monotonic() - self._began, 1e-9)
        left = self.total - self.done
        told = [f"{self.done}/{self.total} done", f"{self.failed} failed"]
        if left:
            told.append(f"{left} left")
        if running:
            told.append(f"{running} running")
        if new and left:
            told += [f"{rate:.3g} points/s", self.time_left()]
        return ", ".join(told)

    def time_left(self) -> str:
        """Return for how long it goes on at its pace so far; empty: nobody knows."""
        new, left = self.done - self._known, self.total - self.done
        return f"{_duration(left * (monotonic() - self._began) / new)} left" if new else ""

    def say(self, text: str) -> None:
        """Say a sentence."""
        if not self._quiet:
            self.clear()
            self._write(f"{text}\n")

    def clear(self) -> None:
        """Take the line away."""
        if self._line:
            self._write("\r\x1b[2K")

    def _write(self, text: str) -> None:
        with contextlib.suppress(OSError):  # nobody reads it any more: no reason to stop
            sys.stderr.write(text)
            sys.stderr.flush()


def _duration(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000.0 else f"{seconds / 3600:.1f} h"
