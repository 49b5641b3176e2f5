"""One rig, and points that are queued for it: a rest between them, and the first fault ends all."""

import time
from collections.abc import Callable

from rig.sweeping.engine import PointReport
from rig.sweeping.errors import SweepStopped
from rig.sweeping.finding import DONE
from rig.sweeping.point import PointJob, perform


class Serial:
    """Runs points in this process, one after the other.

    Parameters
    ----------
    cool_down : float
        Rest before each point but the first, s.
    say : callable
        Told what happens.
    """

    slots = 1

    def __init__(self, cool_down: float, say: Callable[[str], None]) -> None:
        self._cool_down = cool_down
        self._say = say
        self._job: PointJob | None = None
        self._first = True

    def submit(self, job: PointJob) -> None:
        """Take a point."""
        self._job = job

    def wait(self, timeout: float) -> list[PointReport]:
        """Run the point, and return what became of it.

        Raises
        ------
        SweepStopped
            The one before ended with a fault.
        """
        job, self._job = self._job, None
        assert job is not None
        if not self._first:
            time.sleep(self._cool_down)
        self._first = False
        self._say(" ".join(job.options))
        finding = perform(job)
        if finding["status"] == "aborted":
            raise KeyboardInterrupt
        if finding["status"] not in DONE:
            raise SweepStopped("sweep", f"{' '.join(job.options)}: {finding['reason']}")
        return [PointReport(job.name, finding)]

    def close(self) -> None:
        """Nothing is left of it."""
