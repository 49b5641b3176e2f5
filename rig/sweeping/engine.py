"""What runs points: the seam between a sweep and the machines that it goes to."""

from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple, Protocol

from rig.sweeping.finding import PointFinding
from rig.sweeping.point import PointJob

Perform = Callable[[PointJob], PointFinding]


PERFORM: Final = "rig.sweeping.point:perform"
"""Runs an experiment with a point's settings."""


class WorkerSetup(NamedTuple):
    """The needs of a worker before its first point.

    Parameters
    ----------
    perform : str
        What runs a point, ``"module:function"``.
    code : str
        The version of the code that they have to run; empty if it does not matter.
    log : Path or None
        Takes what workers write to their standard error.
    packages : tuple of str
        Those of others whose code takes part, since the profile names it.
    """

    perform: str = PERFORM
    code: str = ""
    log: Path | None = None
    packages: tuple[str, ...] = ()


class PointReport(NamedTuple):
    """A word of an engine about a point.

    Parameters
    ----------
    name : str
        The point's.
    finding : PointFinding or None
        What became of it.
    trouble : str
        Why no point can be run here, if it is so.
    died : bool
        Whether the worker that had it died.
    """

    name: str
    finding: PointFinding | None = None
    trouble: str = ""
    died: bool = False


class Engine(Protocol):
    """Runs points; however it does, what becomes of a point is the same."""

    @property
    def slots(self) -> int:
        """How many points it takes at once."""

    def submit(self, job: PointJob) -> None:
        """Take a point."""

    def wait(self, timeout: float) -> list[PointReport]:
        """Return what is finished, after `timeout` seconds at the latest."""

    def close(self) -> None:
        """End its workers at once."""
