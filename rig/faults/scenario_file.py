"""A case written by hand: what breaks, where, when, for how long, and what breaks next."""

import difflib
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Unit
from pydantic import Field

from rig.config.diagnostics import Problems, nearest, shown
from rig.config.document import load_document
from rig.config.located import Node
from rig.config.named_files import with_path_beside
from rig.config.names import Folder, find_file
from rig.config.quantities import UnitError, parse_quantity
from rig.config.schema import DIALECT, Schema
from rig.config.settings import NUMBER_AND_UNIT, adapter, build
from rig.faults.case import Break, Case, Moment
from rig.faults.catalogue import KINDS, kind_named, kinds_for
from rig.faults.subject import Subject
from rig.hal import ConfigurationError

_Magnitude = float | Annotated[str, Field(pattern=NUMBER_AND_UNIT)]


@dataclass(frozen=True, slots=True)
class When:
    """The moment of a fault.

    Parameters
    ----------
    phase : Moment
        ``rehearsal``, ``connect``, ``energise``, ``approach``, ``run``, ``release`` (after one
        Ctrl-C), ``stop`` (after two) or ``calibration``.
    after : float
        Since the phase began, s.
    """

    phase: Moment = Moment.RUN
    after: Annotated[float, Unit("s"), Ge(0)] = 0.5


@dataclass(frozen=True, slots=True)
class Next:
    """The fault after the first.

    Parameters
    ----------
    fault : str
        What breaks, as `rig faults list RIG` calls it.
    where : str
        One of its places; may be left out if there is one only.
    magnitude : float or str, optional
        How much: with its unit (`20 kPa`), or a number in that which `rig faults list RIG` says.
    lasts : float, optional
        For how long, s; for good without.
    after : float
        Since the first, s.
    """

    fault: str
    where: str = ""
    magnitude: _Magnitude | None = None
    lasts: Annotated[float, Unit("s"), Gt(0)] | None = None
    after: Annotated[float, Unit("s"), Ge(0)] = 0.0


@dataclass(frozen=True, slots=True)
class Scenario:
    """A file of one case.

    Parameters
    ----------
    rig : str
        What is broken: a profile's name, or the path of its file from this one on.
    experiment : str
        What it does meanwhile: an experiment's name or path, or in the phase ``calibration`` the
        procedure.
    fault : str
        What breaks, as `rig faults list RIG` calls it.
    where : str
        One of its places; may be left out if there is one only.
    magnitude : float or str, optional
        How much: with its unit (`20 kPa`), or a number in that which `rig faults list RIG` says.
    lasts : float, optional
        For how long, s; for good without.
    when : When
        At which moment.
    then : Next, optional
        What breaks after it.
    seed : int
        Of the simulated unit.
    """

    rig: str
    experiment: str
    fault: str
    where: str = ""
    magnitude: _Magnitude | None = None
    lasts: Annotated[float, Unit("s"), Gt(0)] | None = None
    when: When = field(default_factory=When)
    then: Next | None = None
    seed: Annotated[int, Ge(0)] = 0


class LocatedScenario(NamedTuple):
    """A scenario, and where in its file each part of it stands."""

    scenario: Scenario
    root: Node


class _Unfit(Exception):
    """The rig, or the phase, has nothing that could break so: the key that says it, and why."""

    def __init__(self, keys: tuple[str, ...], why: str, hint: str | None = None) -> None:
        super().__init__(why)
        self.keys, self.why, self.hint = keys, why, hint


def load_scenario(path: Path, search: Sequence[Path] | None = None) -> LocatedScenario:
    """Load a scenario; strict as every file.

    Parameters
    ----------
    path : Path
        Its file.
    search : sequence of Path, optional
        The folders of configurations in which rig and experiment have to be; default: nobody looks.

    Raises
    ------
    ProfileError
        With every error, located.
    ConfigurationError
        The file cannot be read.
    """
    problems = Problems()
    root = load_document(path, "experiments", (), problems).root
    root = _from_here(root)
    scenario = build(Scenario, root, problems)
    if scenario is not None:
        _check_name(root, ("fault",), scenario.fault, problems)
        if scenario.then is not None:
            _check_name(root, ("then", "fault"), scenario.then.fault, problems)
        if search is not None:
            _check_files(root, scenario, search, problems)
    problems.raise_if_any()
    assert scenario is not None
    return LocatedScenario(scenario, root)


def scenario_schema() -> Schema:
    """Return the JSON Schema of a file of faults, draft 2020-12."""
    made = adapter(Scenario).json_schema()
    for section in (made, made["$defs"]["Next"]):
        # A rig's own plant may know more of them, so another text is no error.
        fault = section["properties"]["fault"]
        fault["anyOf"] = [{"enum": list(KINDS)}, {"type": fault.pop("type")}]
    return {"$schema": DIALECT, **made, "title": "Scenario"}


def _from_here(root: Node) -> Node:
    """Return the document with the files of rig and experiment as paths from here."""
    assert isinstance(root.value, dict)
    named = {key: with_path_beside(root.value.get(key)) for key in ("rig", "experiment")}
    return root.with_items({**root.value, **{key: node for key, node in named.items() if node}})


def _check_files(
    root: Node, scenario: Scenario, search: Sequence[Path], problems: Problems
) -> None:
    """Say which rig or experiment there is not, and where the file names it."""
    named: list[tuple[str, Folder]] = [("rig", "rigs"), ("experiment", "experiments")]
    if scenario.when.phase is Moment.CALIBRATION:  # a procedure of the rig is no file
        named.pop()
    for key, folder in named:
        place, _ = root.descend((key,))
        asked = str(place.value)
        try:
            found = find_file(asked, folder, search)
        except ConfigurationError as error:
            why, _, hint = str(error).partition("; ")
            problems.add(place.mark, why, hint or None)
            continue
        if not found.is_file():
            problems.add(place.mark, f"there is no file {asked}")


def _check_name(root: Node, keys: tuple[str, ...], name: str, problems: Problems) -> None:
    # What is near to none of them may be what the rig's own plant calls a fault.
    if name not in KINDS and difflib.get_close_matches(name, KINDS, n=1):
        place, _ = root.descend(keys)
        problems.add(place.mark, f"no fault is called {shown(name)}", nearest(name, tuple(KINDS)))


def case_of(located: LocatedScenario, subject: Subject, source: str) -> Case:
    """Return the case that a scenario tells of a rig.

    Raises
    ------
    ProfileError
        The rig has nothing that could break so: nothing is left out silently.
    """
    try:
        return _case_of(located.scenario, subject, source)
    except _Unfit as unfit:
        problems = Problems()
        place, _ = located.root.descend(unfit.keys)
        problems.add(place.mark, unfit.why, unfit.hint)
        raise problems.error() from unfit


def _case_of(scenario: Scenario, subject: Subject, source: str) -> Case:
    _check_stretch(scenario, subject)
    then = scenario.then
    first = _break(scenario, subject, ())
    second = None if then is None else _break(then, subject, ("then",))
    return Case(
        scenario.rig,
        scenario.experiment,
        scenario.seed,
        scenario.when.phase,
        scenario.when.after,
        first,
        second,
        0.0 if then is None else then.after,
        None,
        source=source,
        configs=subject.configs,
    )


def _check_stretch(scenario: Scenario, subject: Subject) -> None:
    """Refuse what cannot be expressed in a calibration or a rehearsal."""
    phase, known = scenario.when.phase, tuple(subject.procedures)
    if phase is Moment.CALIBRATION and scenario.experiment not in known:
        raise _Unfit(
            ("experiment",),
            f"no procedure that moves {subject.rig} is called {scenario.experiment!r}",
            nearest(scenario.experiment, known) or "there is none",
        )
    if phase is Moment.REHEARSAL:
        if scenario.then is not None:
            raise _Unfit(("then",), "a rehearsal takes too short for a second fault")
        if not kind_named(scenario.fault).is_rehearsable:
            raise _Unfit(
                ("fault",),
                f"{scenario.fault} cannot be expressed in a rehearsal: it touches no device and "
                "no bus, so only the program and its computer can fail in it",
            )


def _in_unit(asked: Scenario | Next, unit: str, at: tuple[str, ...]) -> float | None:
    """Return the magnitude in SI: which unit is meant, only the fault says."""
    if not isinstance(asked.magnitude, str):
        return asked.magnitude
    try:
        return parse_quantity(asked.magnitude, unit)
    except UnitError as error:
        raise _Unfit((*at, "magnitude"), f"{asked.fault}: magnitude: {error}") from error


def _break(asked: Scenario | Next, subject: Subject, at: tuple[str, ...]) -> Break:
    """Return what breaks; `at`: the keys that lead to it."""
    kind, where, lasts = asked.fault, asked.where, asked.lasts
    if kind not in kinds_for(subject):
        known = kind in KINDS
        why = f"{subject.rig} has nothing that could suffer {kind}"
        raise _Unfit(
            (*at, "fault"),
            why if known else f"no fault is called {shown(kind)}",
            f"rig faults list {shlex.quote(subject.rig)} has what can break on it",
        )
    row = kind_named(kind)
    if asked.magnitude is not None and row.magnitude is None:
        raise _Unfit((*at, "magnitude"), f"{kind} has no magnitude")
    magnitude = None if row.magnitude is None else _in_unit(asked, row.magnitude.unit, at)
    if lasts is not None and row.lasts is None:
        raise _Unfit((*at, "lasts"), f"{kind} is for good: it cannot last {lasts:g} s")
    places = [place.where for place in row.places(subject)]
    if row.magnitude is not None:
        if magnitude is None:
            raise _Unfit((*at, "fault"), f"{kind} needs a magnitude, {row.magnitude}")
        size = abs(magnitude) if row.magnitude.signed else magnitude
        if not row.magnitude.low <= size <= row.magnitude.high:
            why = f"{kind}: magnitude {magnitude:g} is outside {row.magnitude}"
            raise _Unfit((*at, "magnitude"), why)
    if not where and len(places) > 1:
        raise _Unfit((*at, "fault"), f"{kind} needs its place, where: {' or '.join(places)}")
    made = Break(kind, where or (places[0] if len(places) == 1 else ""), magnitude, lasts or inf)
    try:
        made.place(subject)
    except ValueError as error:
        raise _Unfit((*at, "where"), str(error)) from error
    return made
