"""Which points keep their run folders: those that failed, and the best ones so far."""

import bisect
import math
import shutil
from pathlib import Path
from typing import Final

from rig.sweeping.finding import DONE, MISSED, MetricCell, PointFinding

KEEP_ALL: Final = -1


def metric_of(finding: PointFinding, name: str | None) -> MetricCell | None:
    """Return a point's metric by its name, or its first one."""
    return next((m for m in finding["metrics"] if name is None or m["name"] == name), None)


def badness(metric: MetricCell) -> float:
    """Return a number that is less the better a metric is: most have an upper bound, or none."""
    value = metric["value"]
    if math.isnan(value):
        return math.inf
    return -value if metric["kind"] == "min" else value


class Best:
    """The best points so far; the run folders of those that are not are removed.

    Those that missed a bound are behind all that kept theirs.

    Parameters
    ----------
    metric : str or None
        What they are best in; None: the first that a point has.
    keep : int
        How many; `KEEP_ALL` for all.
    logs : Path
        Where the run folders are.
    """

    def __init__(self, metric: str | None, keep: int, logs: Path) -> None:
        self._metric = metric
        self._keep = keep
        self._logs = logs
        self._best: list[tuple[bool, float, str]] = []

    def take(self, finding: PointFinding) -> None:
        """Take a point; remove the run folder that is not wanted any more."""
        if finding["status"] not in DONE or self._keep == KEEP_ALL:
            return
        metric = metric_of(finding, self._metric)
        bad = math.inf if metric is None else badness(metric)
        bisect.insort(self._best, (finding["status"] == MISSED, bad, finding["point"]))
        if len(self._best) > self._keep:
            shutil.rmtree(self._logs / self._best.pop()[2], ignore_errors=True)

    def recall(self, finding: PointFinding) -> None:
        """Take a point that was finished before, if its run folder is still there."""
        if (self._logs / finding["point"]).is_dir():
            self.take(finding)
