"""Two runs beside each other: settings, code, metrics, and the first cycle that differs."""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rig.config.dump import REFERENCE_FILES
from rig.config.located import Plain
from rig.config.yaml_loader import read_plain
from rig.hal import ConfigurationError, RigError
from rig.replaying.recorded import EXPERIMENT, PROFILE
from rig.report.timing import TimingSummary
from rig.run_facts import MANIFEST, TIMING, MetricRow, never_came
from rig.run_folder import RunFolder
from rig.runtime.log_columns import read_columns
from rig.typed_json import checked

_WALL_CLOCK = "timing."
"""Group of columns that differ from run to run, whatever ran."""
_ENOUGH = 3
"""Runs with other seeds from which a spread is told."""
_SEED = "simulation.seed"


class Change(NamedTuple):
    """Something that the two runs say differently; empty where one does not say it."""

    what: str
    first: str
    second: str


class MetricChange(NamedTuple):
    """A metric of both runs.

    Parameters
    ----------
    name, unit : str
        As in ``metrics.json``.
    first, second : float
        SI; infinite where what it times never happened, NaN where it has no value.
    spread : float or None
        Standard deviation over runs that differ in nothing but their seed, SI; None: unknown.
    """

    name: str
    unit: str
    first: float
    second: float
    spread: float | None

    @property
    def by_chance(self) -> str:
        """Say whether chance explains the difference."""
        if self.first == self.second or (math.isnan(self.first) and math.isnan(self.second)):
            return "the same"
        if self.spread is None:
            return "spread over seeds unknown"
        # The difference of two runs has the standard deviation of one, times the root of two.
        bound = 2.0 * math.sqrt(2.0) * self.spread
        return (
            "as chance may have it"
            if abs(self.second - self.first) <= bound
            else "more than chance"
        )


def differing_settings(one: RunFolder, other: RunFolder) -> list[Change]:
    """Return the settings of profile and experiment that differ."""
    settings = [
        change
        for name in (PROFILE, EXPERIMENT)
        for change in _changes(_settings(one, name), _settings(other, name))
    ]
    return settings + _changes(_tables(one), _tables(other))


def differing_code(one: RunFolder, other: RunFolder) -> list[Change]:
    """Return what differs of checkout, versions and backend."""
    return _changes(_code(one), _code(other))


def metrics_beside(
    one: RunFolder, other: RunFolder, siblings: Mapping[str, Sequence[float]]
) -> list[MetricChange]:
    """Return every metric of either run.

    Parameters
    ----------
    one, other : RunFolder
        The runs.
    siblings : mapping
        Values of metrics in runs that are like the first but for their seed, see `siblings_of`.
    """
    first, second = _metrics(one), _metrics(other)
    nan = (math.nan, "")
    return [
        MetricChange(
            name,
            (first.get(name) or second[name])[1],
            first.get(name, nan)[0],
            second.get(name, nan)[0],
            float(np.std(siblings[name], ddof=1))
            if len(siblings.get(name, ())) >= _ENOUGH
            else None,
        )
        for name in dict.fromkeys((*first, *second))
    ]


class TimeChange(NamedTuple):
    """A time of the cycles of both runs.

    Parameters
    ----------
    stage : str
        As in ``timing.json``; ``work``: all of them.
    which : str
        ``median`` or ``p99``.
    first, second : float
        s.
    """

    stage: str
    which: str
    first: float
    second: float


def times_beside(one: RunFolder, other: RunFolder) -> list[TimeChange]:
    """Return how long the cycles of two runs took; nothing if either run does not say."""
    try:
        both = [
            checked(folder.read_json(TIMING, dict[str, object]), TimingSummary, TIMING)
            for folder in (one, other)
        ]
    except ConfigurationError:  # there is none, or its log has no times
        return []
    found: list[TimeChange] = []
    first, second = ({"work": of["work"], **of["stages"]} for of in both)
    for stage in (name for name in first if name in second):
        a, b = first[stage], second[stage]
        found.append(TimeChange(stage, "median", a["p50"], b["p50"]))
        found.append(TimeChange(stage, "p99", a["p99"], b["p99"]))
    return found


def siblings_of(folder: RunFolder, runs: Path) -> dict[str, list[float]]:
    """Return the metrics of all runs in a folder that differ from one in their seed alone."""
    own, code = _without_seed(folder), _code(folder)
    found: dict[int | None, dict[str, tuple[float, str]]] = {}
    for path in sorted(runs.iterdir()) if runs.is_dir() else ():
        if not (path / MANIFEST).is_file():
            continue
        try:
            run = RunFolder.open(path)
            if _code(run) == code and _without_seed(run) == own:
                found.setdefault(run.manifest.get("seed"), _metrics(run))
        except RigError:
            continue  # whatever somebody made of it, it is no run like this one
    values: dict[str, list[float]] = {}
    for metrics in found.values():
        for name, (value, _) in metrics.items():
            if math.isfinite(value):
                values.setdefault(name, []).append(value)
    return values


def first_difference(one: RunFolder, other: RunFolder) -> str | None:
    """Say at which cycle, and in which column, two logs first differ; None if they do not.

    Wall-clock times are left out: they differ from run to run.

    Raises
    ------
    LogError
        One of them has no readable log.
    """
    first, second = read_columns(one.log_path), read_columns(other.log_path)
    names = [c.name for c in first.columns if not c.name.startswith(_WALL_CLOCK)]
    others = {c.name for c in second.columns}
    units = {c.name: c.unit for c in first.columns}
    shared = [name for name in names if name in others]
    count = min(len(first.cycle), len(second.cycle))
    differs = (first.cycle[:count] != second.cycle[:count]).astype(bool)
    differs |= first.t[:count].view(np.uint64) != second.t[:count].view(np.uint64)
    for name in shared:
        a, b = (np.ascontiguousarray(log.column(name)[:count]) for log in (first, second))
        differs |= a.view(np.uint64) != b.view(np.uint64)
    if differs.any():
        row = int(np.argmax(differs))
        at = f"cycle {int(first.cycle[row])} ({float(first.t[row]):.4f} s)"
        there = [(name, *(log.column(name)[row] for log in (first, second))) for name in shared]
        told = [
            f"{name} {float(a)!r} against {float(b)!r} {units[name]}".rstrip()
            for name, a, b in there
            if a.tobytes() != b.tobytes()
        ]
        more = f", and {len(told) - 1} more columns" if len(told) > 1 else ""
        return f"{at}: {told[0]}{more}" if told else f"{at}: it came at another time"
    if len(first.cycle) != len(second.cycle):
        lengths = f"one log has {len(first.cycle)} cycles, the other {len(second.cycle)}"
        return f"the end of the shorter one: {lengths}"
    left = sorted(set(names) ^ {n for n in others if not n.startswith(_WALL_CLOCK)})
    return f"only one log has {', '.join(left)}" if left else None


def _tables(folder: RunFolder) -> dict[str, str]:
    """Return the hash of each file that the reference named; its name there says nothing."""
    kept = folder.manifest.get("files", {})
    return {name: sha for name, sha in kept.items() if name.startswith(f"{REFERENCE_FILES}/")}


def _without_seed(folder: RunFolder) -> dict[str, str]:
    settings = _settings(folder, PROFILE) | _settings(folder, EXPERIMENT) | _tables(folder)
    settings.pop(_SEED, None)
    return settings


def _metrics(folder: RunFolder) -> dict[str, tuple[float, str]]:
    return {
        metric["name"]: (
            _value(metric),
            metric.get("unit", ""),
        )
        for metric in folder.metrics()
    }


def _value(metric: MetricRow) -> float:
    value = metric["value"]
    if value is not None:
        return value
    return math.inf if never_came(metric) else math.nan


def _code(folder: RunFolder) -> dict[str, str]:
    manifest = folder.manifest
    git = manifest.get("git")
    told = {"backend": str(manifest.get("backend"))}
    if git:
        told |= {"git commit": str(git["commit"]), "uncommitted changes": str(git["dirty"])}
    return told | {name: str(version) for name, version in manifest.get("versions", {}).items()}


def _settings(folder: RunFolder, name: str) -> dict[str, str]:
    try:
        return dict(_flat("", read_plain(folder.path / name)))
    except ConfigurationError as error:
        raise ConfigurationError(f"{folder.path} has no readable {name}: {error}") from error


def _flat(prefix: str, value: Plain) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict) and value:
        for key, item in value.items():
            yield from _flat(f"{prefix}.{key}" if prefix else str(key), item)
    else:
        yield prefix, str(value)


def _changes(first: Mapping[str, str], second: Mapping[str, str]) -> list[Change]:
    return [
        Change(key, first.get(key, ""), second.get(key, ""))
        for key in dict.fromkeys((*first, *second))
        if first.get(key) != second.get(key)
    ]
