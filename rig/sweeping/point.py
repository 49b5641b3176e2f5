"""One point, run where a worker is."""

import re
import shutil
from pathlib import Path
from typing import Final, NamedTuple

from rig.assembly import Backend
from rig.config import ProfileError
from rig.experiment.metrics import Metric
from rig.experiment.plan import make_plan
from rig.experiment.run import Result, run_experiment
from rig.hal import ConfigurationError, RigError
from rig.installation import missing_package
from rig.run_facts import RunStatus
from rig.sweeping.errors import SweepStopped
from rig.sweeping.finding import MetricCell, PointFinding, one_line, refusal
from rig.sweeping.source import PointSource, resolve

_ADDRESS: Final = re.compile(r" at 0x[0-9a-f]{6,}")
_DISK: Final = re.compile(
    "No space left on device|Disk quota exceeded|Input/output error|Read-only file system"
    "|Too many open files"
    "|Cannot allocate memory"
)


class PointJob(NamedTuple):
    """A point as a worker gets it.

    Parameters
    ----------
    name : str
        Its name.
    source : PointSource
        What it has in common with the others.
    options : tuple of str
        What is its own.
    configs : Path
        The folder of the configurations, where the worker is.
    logs : Path
        Where its run folder goes, under its name.
    """

    name: str
    source: PointSource
    options: tuple[str, ...]
    configs: Path
    logs: Path


def perform(job: PointJob) -> PointFinding:
    """Run a point; return what became of it.

    Raises
    ------
    SweepStopped
        Something else than the point's settings keeps it from running: the disk, say.
    ModuleNotFoundError
        A package is not installed here.
    """
    resolved = resolve(job.source, job.options, job.configs)
    if resolved.name != job.name:
        raise SweepStopped(
            "sweep",
            "the configurations are not what they were when it began; start it again",
        )
    try:
        plan = make_plan(resolved.experiment, resolved.profile)
    except ConfigurationError as error:
        return refusal(job.name, error)
    place, kept = job.logs / f".{job.name}", job.logs / job.name
    shutil.rmtree(place, ignore_errors=True)
    try:
        result = run_experiment(
            plan, Backend(job.source.backend), place,
            overrides=(*job.source.options, *job.options), report=False,
            uncommissioned=job.source.uncommissioned,
        )  # fmt: skip
    except RigError as error:
        _refuse_if_outside(str(error), job)
        finding = refusal(job.name, error)
    except Exception as error:
        if missing_package(error) is not None:  # no point would fare better here
            shutil.rmtree(place, ignore_errors=True)
            raise
        finding = PointFinding(
            point=job.name, status=RunStatus.CRASHED.value,
            reason=_ADDRESS.sub("", one_line(f"{type(error).__name__}: {error}")), metrics=[],
        )  # fmt: skip
    else:
        _refuse_if_outside(result.message or "", job)
        finding = _finding(job.name, result)
    _keep(place, kept)
    return finding


def _finding(name: str, result: Result) -> PointFinding:
    missed = ", ".join(metric.name for metric in result.metrics if metric.passed is False)
    reason = "; ".join(filter(None, (result.message, missed and f"missed {missed}")))
    return PointFinding(
        point=name, status=result.status.value, reason=one_line(reason),
        metrics=[_cell(metric) for metric in result.metrics],
    )  # fmt: skip


def _cell(metric: Metric) -> MetricCell:
    return MetricCell(
        name=metric.name, value=float(metric.value), unit=metric.unit,
        bound=metric.bound, kind=metric.bound_kind,
    )  # fmt: skip


def _refuse_if_outside(message: str, job: PointJob) -> None:
    """Raise if a message is about the place where the point ran, and not about the point."""
    trouble = _DISK.search(message)
    if trouble or str(job.logs) in message:
        hidden = job.logs / f".{job.name}"
        shutil.rmtree(hidden, ignore_errors=True)
        seen = message.replace(str(hidden), str(job.logs))
        what = f"{job.logs}: {trouble[0]}" if trouble else seen
        raise SweepStopped(
            "sweep", f"{what}; what is finished is kept, and the same command goes on from there"
        )


def _keep(place: Path, kept: Path) -> None:
    """Give the run folder the name of its point."""
    shutil.rmtree(kept, ignore_errors=True)
    for folder in place.iterdir() if place.is_dir() else ():
        folder.rename(kept)
    shutil.rmtree(place, ignore_errors=True)


def reason_of(error: ConfigurationError) -> str:
    """Return why settings are refused, without the place where they are written."""
    if isinstance(error, ProfileError):
        return "; ".join(one_line(diagnostic.message) for diagnostic in error.diagnostics)
    return one_line(str(error))
