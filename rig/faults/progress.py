"""The progress of a campaign: a line on a terminal, a few lines in a pipe, failures in both."""

import sys
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from rig.faults.verdict import Verdict


class CampaignProgress:
    """Shows how many cases are done, and each that went wrong.

    Parameters
    ----------
    total : int
        Cases of the campaign.
    """

    def __init__(self, total: int) -> None:
        self._console = Console(file=sys.stderr, highlight=False, soft_wrap=True)
        self._bar = Progress(
            TextColumn("faults"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
            console=self._console, disable=not sys.stderr.isatty(), transient=True,
        )  # fmt: skip
        self._task = self._bar.add_task("faults", total=total)
        self._total, self._done, self._failed = total, 0, 0

    def __enter__(self) -> "CampaignProgress":
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bar.stop()
        self._say(f"{self._done} of {self._total} cases, {self._failed} went wrong")

    def told(self, verdict: Verdict) -> None:
        """Take a verdict."""
        self._done += 1
        self._bar.advance(self._task)
        if verdict.failed:
            self._failed += 1
            for wrong in verdict.wrongs():
                self._say(f"  {wrong}")
            self._say(f"    {verdict.case.command}")
        if not sys.stderr.isatty() and self._done % 50 == 0:
            self._say(f"{self._done} of {self._total} cases")

    def _say(self, text: str) -> None:
        self._console.print(text, markup=False)
