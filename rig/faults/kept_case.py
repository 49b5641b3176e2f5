"""The folder that a case leaves: what was done to the rig, what was true, and what was wrong."""

import contextlib
import json
import shlex
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, replace
from math import inf, isinf
from pathlib import Path
from typing import Final, NamedTuple, TypedDict

import numpy as np
from pydantic import TypeAdapter, ValidationError

from rig.faults.case import Break, Case
from rig.faults.oracle import Samples, judged_values
from rig.faults.stage import Truth
from rig.faults.verdict import Verdict
from rig.hal import Column, ConfigurationError
from rig.hal.formats import format_quantity
from rig.hal.hazards import Hazard
from rig.json_file import write_json
from rig.run_facts import EVENTS, MANIFEST, TRUTH, TRUTH_COLUMNS, read_manifest
from rig.typed_json import read_json

CASE: Final = "case.json"
"""What broke and when, so that it can be done again."""


class RunClock(NamedTuple):
    """The clock of all times that a case tells: that of the run's log, if it came so far.

    Parameters
    ----------
    start : float
        Where it begins in the world's time, s.
    since : str
        With what it begins.
    """

    start: float = 0.0
    since: str = "it began to connect"

    def of(self, at: float) -> float:
        """Return a world time on this clock, s."""
        return at - self.start

    def or_never(self, at: float | None) -> float | None:
        """Return a world time on this clock, s; None: it never was."""
        return None if at is None else self.of(at)


def clock_of(running_from: float | None) -> RunClock:
    """Return the clock of a run that has begun at a world time, s; None: it never did."""
    return RunClock() if running_from is None else RunClock(running_from, "the run began")


def note_break(folder: Path, item: Break, t: float | None) -> None:
    """Write into a run's events what was done to it.

    Parameters
    ----------
    folder : Path
        Of the run.
    item : Break
        What breaks.
    t : float or None
        When on the log's clock, s; None before there is one.
    """
    kind = item.row
    data = {"fault": item.kind, "where": item.where, "magnitude": item.magnitude}
    words = [item.where]
    if item.magnitude is not None and kind.magnitude is not None:
        data["unit"] = kind.magnitude.unit
        words.append(format_quantity(item.magnitude, kind.magnitude.unit))
    if not isinf(item.lasts):
        data["lasts"] = item.lasts
        words.append(f"for {format_quantity(item.lasts, 's')}")
    _append(folder, t, "injected", f"{kind.what.rstrip('.')}: {', '.join(words)}", data)


def _append(folder: Path, t: float | None, kind: str, message: str, data: object) -> None:
    event = {"t": t, "kind": kind, "message": message, "data": data}
    with (
        contextlib.suppress(OSError),  # the disk may be full by now
        (folder / EVENTS).open("a", encoding="utf-8") as file,
    ):
        file.write(json.dumps(event, ensure_ascii=False) + "\n")


def describe_truth(logged: Sequence[Column], drives: Iterable[str]) -> list[Column]:
    """Return the columns of a stage's truth: those of the log, and the power of each drive."""
    return [
        *(column._replace(name=column.name.removeprefix("truth.")) for column in logged),
        *(Column(f"powered_{axis}", "1", "1 while the drive has torque") for axis in drives),
    ]


class WholeTruth(NamedTuple):
    """The truth of a case from its beginning on, and what it is judged by.

    Parameters
    ----------
    columns : sequence of Column
        Of the truth.
    truth : Truth
        In the world's time.
    hazards : sequence of Hazard
        Of the rig.
    ended_at : float
        When the program ended or died, s.
    """

    columns: Sequence[Column]
    truth: Truth
    hazards: Sequence[Hazard]
    ended_at: float

    def judged(self, times: Samples, rows: Samples) -> Iterator[tuple[dict[str, object], Samples]]:
        """Yield each quantity that has bounds, what it is, and its values, shape (n,)."""
        names = [column.name for column in self.columns]
        for hazard in self.hazards:
            what = {
                "hazard": hazard.name, "unit": hazard.unit, "low": hazard.low, "high": hazard.high,
                "only_safe": hazard.only_safe,
            }  # fmt: skip
            for column in hazard.columns:
                values = judged_values(hazard, times, rows[:, names.index(column)])
                yield {"column": column, **what}, values


def keep_case(folder: Path, verdict: Verdict, whole: WholeTruth, clock: RunClock) -> None:
    """Write into a run's folder what was true of it, and what was wrong.

    Parameters
    ----------
    folder : Path
        Of the run.
    verdict : Verdict
        On the case.
    whole : WholeTruth
        What was true.
    clock : RunClock
        Which everything that is written tells the time of.
    """
    times, rows = (np.array(values) for values in whole.truth)
    judged = list(whole.judged(times, rows))
    np.savez_compressed(
        folder / TRUTH, columns=[column.name for column in whole.columns], t=times - clock.start,
        truth=rows, judged=np.column_stack([values for _, values in judged]),
    )  # fmt: skip
    told = {
        "t": f"s since {clock.since}, as in events.jsonl",
        "ended": clock.of(whole.ended_at),
        "columns": [column._asdict() for column in whole.columns],
        "judged": [what for what, _ in judged],
    }
    write_json(folder / TRUTH_COLUMNS, told)
    write_json(folder / CASE, {"case": asdict(verdict.case), "again": verdict.case.command})
    for violation in verdict.ending.violations:
        _append(folder, violation.t, "hazard", str(violation), violation._asdict())
    for violation in verdict.ending.excused:
        _append(folder, violation.t, "not counted", str(violation), violation._asdict())
    manifest = read_manifest(folder)
    manifest["command"] = shlex.split(verdict.case.command)
    if verdict.failed:
        manifest["wrongs"] = list(verdict.wrongs())
    if verdict.ending.excused:
        manifest["uncounted"] = list(verdict.uncounted())
    write_json(folder / MANIFEST, manifest)


class _KeptCase(TypedDict):
    """The content of ``case.json``; null for how long what is for good lasts."""

    case: dict[str, object]
    again: str


def load_case(folder: Path) -> Case | None:
    """Return the case that a run's folder tells of; None: it is of none.

    Raises
    ------
    ConfigurationError
        What it tells is damaged.
    """
    path = folder / CASE
    if not path.is_file():
        return None
    kept = read_json(path, _KeptCase)
    for item in (kept["case"].get("first"), kept["case"].get("then")):
        if isinstance(item, dict) and item.get("lasts") is None:
            item["lasts"] = inf
    try:
        case = TypeAdapter(Case).validate_python(kept["case"])
    except ValidationError as error:
        raise ConfigurationError(f"{folder} is not a whole run folder: {path}: {error}") from error
    return replace(case, again=kept["again"])
