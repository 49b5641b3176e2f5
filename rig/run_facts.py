"""The facts of a run as its folder keeps them, each file with a type: checked where it is read."""

import contextlib
import os
import re
from datetime import datetime
from enum import StrEnum
from pathlib import Path
from typing import Final, NotRequired, Required, TypedDict

from rig.hal import ConfigurationError
from rig.hal.files import read_regular
from rig.typed_json import MOST, checked, parse, read_json

FORMAT: Final = 1
"""Of run folders. A manifest that does not say it is of the first."""

MANIFEST = "manifest.json"
LOG = "log.mcap"
EVENTS = "events.jsonl"
EVALUATION = "evaluation.json"
METRICS = "metrics.json"
TIMING = "timing.json"
MARGINS, UNTOLD = "margins.json", "untold"
"""The loop that `rig margins` has measured; the key of what it says where nothing was told."""
REPORT, FIGURES = "report.html", "figures"
TRUTH, TRUTH_COLUMNS = "truth.npz", "truth.json"
"""Of a case that was broken: arrays ``t``, ``truth`` and ``judged``, and what their columns are."""


_COMMIT: Final = re.compile("[0-9a-f]{40,64}")


class RunStatus(StrEnum):
    """The state of a run, or how it ended."""

    RUNNING = "running"
    OK = "ok"
    FAILED = "failed"
    """It ran to its end and missed an acceptance bound, or has another flaw."""
    ABORTED = "aborted"
    """It was interrupted and made safe."""
    FAULTED = "faulted"
    CRASHED = "crashed"
    """A bug ended it, or the process died; the log holds what had happened until then."""


class GitState(TypedDict):
    """A checkout: its commit, and whether files differ from it or a run may use others."""

    commit: str
    dirty: bool


class PlugIn(TypedDict):
    """A package of others, as the manifest of a run names it."""

    distribution: str | None
    version: str | None
    sha256: str


class Manifest(TypedDict, total=False):
    """The facts of a run, as ``manifest.json`` keeps them."""

    format: int
    status: Required[str]
    experiment: str
    backend: str
    seed: int | None
    rig: str
    law: str
    command: list[str]
    started: str
    ended: str | None
    exit_code: int | None
    message: str | None
    wrongs: list[str]
    """What a campaign found wrong about it, by the plant's truth."""
    uncounted: list[str]
    """Hazards that came true and that nothing could have kept off."""
    git: GitState | None
    versions: dict[str, str]
    plug_ins: dict[str, PlugIn]
    machine: dict[str, object]
    files: dict[str, str]


MetricRow = TypedDict(
    "MetricRow",
    {
        "name": str,
        "value": float | None,
        "unit": str,
        "bound": NotRequired[float | None],
        "bound_kind": NotRequired[str | None],
        "pass": NotRequired[bool | None],
        "measure": NotRequired[str],
        "segments": NotRequired[str],
        "is_nan": NotRequired[bool],
    },
)
"""One entry of ``metrics.json``, SI."""


class MetricRows(TypedDict):
    """The content of ``metrics.json``."""

    metrics: list[MetricRow]


def never_came(metric: MetricRow) -> bool:
    """Return whether a metric times what never happened; a value that is none may be unseen."""
    is_unseen = metric.get("bound") is not None and metric.get("pass") is None
    return metric["value"] is None and not metric.get("is_nan", False) and not is_unseen


class Event(TypedDict, total=False):
    """One line of ``events.jsonl``; `t` is on the rig's clock, s."""

    t: float | None
    kind: str
    message: str
    data: dict[str, object]


def read_manifest(folder: Path) -> Manifest:
    """Return the facts of a run.

    Raises
    ------
    ConfigurationError
        The folder is none of a run, or one that a later version recorded.
    """
    try:
        content = read_json(folder / MANIFEST, dict[str, object])
        _check_format(content)
        manifest = checked(content, Manifest, f"its {MANIFEST}")
        if manifest["status"] not in list(RunStatus):
            raise ConfigurationError(f"its {MANIFEST} has no status that a run can have")
        for stamp in (manifest.get("started"), manifest.get("ended")):
            _check_stamp(stamp)
        git = manifest.get("git")
        if git is not None and not _COMMIT.fullmatch(git["commit"]):
            raise ConfigurationError(f"its {MANIFEST} has a git commit that is none")
    except ConfigurationError as error:
        what = f"{folder} is not a run folder that can be read"
        raise ConfigurationError(f"{what}: {error}") from error
    return manifest


def read_metrics(folder: Path) -> list[MetricRow]:
    """Return the entries of a run's ``metrics.json``; none if it has no such file.

    Raises
    ------
    ConfigurationError
        It holds something else.
    """
    path = folder / METRICS
    return read_json(path, MetricRows)["metrics"] if os.path.lexists(path) else []


def read_events(folder: Path) -> list[Event]:
    """Return a run's events; a line that is none, the torn last one say, is left out.

    Raises
    ------
    ConfigurationError
        There is something else than a file of lines.
    """
    path = folder / EVENTS
    if not os.path.lexists(path):
        return []
    events = []
    for line in read_regular(path, MOST).decode(errors="replace").split("\n"):
        with contextlib.suppress(ValueError, RecursionError, ConfigurationError):
            events.append(checked(parse(line), Event, EVENTS))
    return events


def has_moved(folder: Path) -> bool:
    """Return whether a run got as far as its first cycle, or may have.

    Raises
    ------
    ConfigurationError
        See `read_events`.
    """
    if (folder / TIMING).exists():
        return True
    states = [event for event in read_events(folder) if event.get("kind") == "state"]
    is_early = {"disconnected", "idle"}.issuperset
    return not is_early(event.get("data", {}).get("new") for event in states)


def _check_format(manifest: dict[str, object]) -> None:
    said = manifest.get("format", FORMAT)
    if not isinstance(said, int) or said <= FORMAT:
        return
    versions = manifest.get("versions")
    version = versions.get("rig-controller") if isinstance(versions, dict) else None
    raise ConfigurationError(
        f"rig {version or 'of a later version'} recorded it in format {said}, and this version "
        f"reads formats up to {FORMAT}"
    )


def _check_stamp(stamp: str | None) -> None:
    if stamp is None:
        return
    with contextlib.suppress(ValueError):
        if datetime.fromisoformat(stamp).utcoffset() is not None:
            return
    raise ConfigurationError(f"its {MANIFEST} has a time that is none: {stamp[:40]!r}")


def ending_word(status: str, *, is_flawed: bool) -> str:
    """Return a run's status for a person, or what came of it where that would not say it.

    Parameters
    ----------
    status : str
        Of the run.
    is_flawed : bool
        Whether something else is said of a run that failed than that it missed a bound.
    """
    if status != "failed":
        return status
    return "flawed" if is_flawed else "bound missed"
