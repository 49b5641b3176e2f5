"""What runs next, and what becomes of it: the loop between points, engine and journal."""

from collections.abc import Callable, Iterator
from time import monotonic
from typing import Final, NamedTuple

from rig.sweeping.best import Best
from rig.sweeping.engine import Engine, PointReport
from rig.sweeping.errors import SweepStopped
from rig.sweeping.finding import LOST, PointFinding
from rig.sweeping.journal import Journal
from rig.sweeping.point import PointJob
from rig.sweeping.progress import SweepProgress

TRIES: Final = 6
"""So many workers may die of a point before it counts as lost."""
_LOOK: Final = 0.5
"""Longest wait before the progress is told again, s."""

Task = PointJob | PointFinding
"""A point to run, or what became of one that cannot be."""


class Limits(NamedTuple):
    """The bounds that end a sweep before its last point.

    Parameters
    ----------
    seconds, points : float or None
        No point begins after so long, or after so many in this go.
    reached : callable, optional
        Says of a finding whether the sweep may end there.
    """

    seconds: float | None = None
    points: float | None = None
    reached: Callable[[PointFinding], bool] | None = None


class Coordinator:
    """Runs the points of a sweep that are not in its journal.

    Parameters
    ----------
    journal : Journal
        Of what is finished.
    engine : Engine
        Runs them.
    progress : SweepProgress
        Is told what is finished.
    limits : Limits
        What ends it early.
    best : Best
        Chooses whose run folders stay.
    """

    def __init__(
        self,
        journal: Journal,
        engine: Engine,
        progress: SweepProgress,
        limits: Limits,
        best: Best,
    ) -> None:
        self._journal = journal
        self._engine = engine
        self._progress = progress
        self._limits = limits
        self._best = best
        self._jobs: dict[str, PointJob] = {}
        self._numbers: dict[str, int] = {}
        self._deaths: dict[str, int] = {}
        self.names = bytearray()
        """The names of all points so far in their order, sixteen bytes each."""
        self.end: int | None = None
        """The number of the first point with which the sweep may end."""
        self.lost: dict[str, PointFinding] = {}
        """What became of points that are not finished."""
        self.cut = False
        """Whether a budget was spent before the last point."""

    def run(self, tasks: Iterator[Task]) -> None:
        """Run all points that are not finished.

        Raises
        ------
        SweepStopped
            They cannot be run any more; what is finished is kept.
        """
        began, started = monotonic(), 0
        number = 0
        more = True
        while more or self._jobs:
            while more and len(self._jobs) < self._engine.slots:
                if self._spent(began, started):
                    self.cut = more = next(tasks, None) is not None
                    more = False
                    break
                task = next(tasks, None)
                if task is None or (self.end is not None and number > self.end):
                    more = False
                    break
                started += self._begin(number, task)
                number += 1
            if self._jobs:
                for report in self._engine.wait(_LOOK):
                    self._take(report)
                self._progress.show(len(self._jobs))

    def _spent(self, began: float, started: int) -> bool:
        seconds, points = self._limits.seconds, self._limits.points
        return (seconds is not None and monotonic() - began >= seconds) or (
            points is not None and started >= points
        )

    def _begin(self, number: int, task: Task) -> bool:
        """Begin with a point unless it is finished or under way; return whether it began."""
        name = task.name if isinstance(task, PointJob) else task["point"]
        self.names += bytes.fromhex(name)
        if name in self._journal:
            finding = self._journal[name]
            self._look(number, finding)
            self._best.recall(finding)
            self._progress.known()
            return False
        if name in self._jobs:
            return False
        self._numbers[name] = number
        if isinstance(task, PointJob):
            self._jobs[name] = task
            self._engine.submit(task)
            return True
        self._keep(task)
        return False

    def _take(self, report: PointReport) -> None:
        if report.trouble:
            raise SweepStopped("sweep", report.trouble)
        if report.finding is not None:
            self._jobs.pop(report.name, None)
            self._keep(report.finding)
            return
        deaths = self._deaths[report.name] = self._deaths.get(report.name, 0) + 1
        job = self._jobs[report.name]
        if deaths < TRIES:
            self._engine.submit(job)
            return
        del self._jobs[report.name]
        self._numbers.pop(report.name)
        reason = f"{TRIES} workers died while they ran it"
        finding = PointFinding(point=report.name, status=LOST, reason=reason, metrics=[])
        self.lost[report.name] = finding
        self._progress.told(finding)

    def _keep(self, finding: PointFinding) -> None:
        self._journal.add(finding)
        self._deaths.pop(finding["point"], None)
        self._look(self._numbers.pop(finding["point"]), finding)
        self._best.take(finding)
        self._progress.told(finding)

    def _look(self, number: int, finding: PointFinding) -> None:
        reached = self._limits.reached
        if reached is not None and reached(finding):
            self.end = number if self.end is None else min(self.end, number)
