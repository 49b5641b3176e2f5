"""The progress of a campaign: a line on a terminal, a few lines in a pipe, failures in both."""

import sys
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from rig.faults.quiet import QuietEnding
from rig.faults.verdict import Verdict
from rig.terminals import is_terminal


class _Progress:
    """Shows how many are done, and each that went wrong.

    Parameters
    ----------
    total : int
        How many there are.
    """

    things = ""
    """What is counted."""

    def __init__(self, total: int) -> None:
        self._console = Console(file=sys.stderr, highlight=False, soft_wrap=True)
        self._bar = Progress(
            TextColumn("faults"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
            console=self._console, disable=not is_terminal(sys.stderr), transient=True,
        )  # fmt: skip
        self._task = self._bar.add_task("faults", total=total)
        self._total, self._done, self._failed = total, 0, 0

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bar.stop()
        self._say(f"{self._done} of {self._total} {self.things}, {self._failed} went wrong")

    def _take(self, wrongs: Sequence[str], command: str, folder: str = "") -> None:
        """Count one that is done: what is wrong, the line that repeats it, and what it left."""
        self._done += 1
        self._bar.advance(self._task)
        if wrongs:
            self._failed += 1
            for wrong in wrongs:
                self._say(f"  {wrong}")
            self._say(f"    {command}")
            if folder:
                self._say(f"    {_from_here(folder)}")
        if not is_terminal(sys.stderr) and self._done % 50 == 0:
            self._say(f"{self._done} of {self._total} {self.things}")

    def _say(self, text: str) -> None:
        self._console.print(text, markup=False)


class CampaignProgress(_Progress):
    """Shows the cases of a campaign."""

    things = "cases"

    def told(self, verdict: Verdict) -> None:
        """Take a verdict."""
        self._take(list(verdict.wrongs()), verdict.case.command, verdict.folder)


class QuietProgress(_Progress):
    """Shows the runs of quiet hours."""

    things = "runs"

    def told(self, ending: QuietEnding) -> None:
        """Take an ending."""
        wrong = [f"false trip: {ending.message}"] if ending.is_trip else []
        self._take(wrong, ending.run.command)


def _from_here(folder: str) -> Path:
    """Return a folder as a path from here, if it is below."""
    path = Path(folder)
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
