"""A run that is broken on cue, in one of many ways: the program as it is, on a stage."""

import random
import re
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path
from typing import Any, cast

import numpy as np

from rig.assembly import Rig
from rig.experiment.watcher import Watcher
from rig.faults.case import RUN_SHARE, Break, Case, Moment
from rig.faults.felt import Felt
from rig.faults.kept_case import WholeTruth, clock_of, describe_truth, keep_case, note_break
from rig.faults.kind import Plight
from rig.faults.oracle import Violation, judge
from rig.faults.stage import PausableClock, Program, RehearsalStage, Stage, Truth
from rig.faults.subject import Subject
from rig.faults.verdict import CaseEnding, Verdict, give_verdict
from rig.hal import Controller
from rig.hal.controller import AnyController
from rig.hal.hazards import ENERGY_LEFT
from rig.run_facts import LOG
from rig.runtime.phases import Timings
from rig.runtime.states import RigState

AFTERMATH = 1.5
"""How long the world is watched after the program has ended or died, s."""
HORIZON = 1.0
"""How long the run may go on after the last fault until it is asked to stop, s; or for as long as a
fault may take to be seen that shows before."""


class _Spoilt(Controller[Any, Any, Any]):
    """A controller whose commands the stage may spoil."""

    def __init__(
        self, inner: Controller[Any, Any, Any], program: Program, felt: Callable[[], None]
    ) -> None:
        self._inner = inner
        self._program = program
        self._felt = felt

    def reset(self, state: Any) -> None:
        """Start from the measured state."""
        self._inner.reset(state)

    def update(self, state: Any, reference: Any) -> Any:
        """Return the command, spoilt if it is to be."""
        command = self._inner.update(state, reference)
        spoils = self._program.spoils
        if spoils is None:
            return command
        self._felt()  # a law that nobody follows yet, while the rig is energised, harms nobody
        return spoils(command)


class Performance(Watcher):
    """A run that goes on undisturbed until the moment of one of its cases comes.

    Parameters
    ----------
    cases : sequence of Case
        Of one experiment and one seed.
    subject : Subject
        The rig.
    branch : callable
        Called at the moment of a case; returns what this process performs of it, or None.
    over : callable
        Called when no case is left; does not return.
    dies : callable
        Called when the program is killed; does not return.
    keeps : bool
        Whether the folder is kept of what goes well, too.
    """

    def __init__(
        self,
        cases: Sequence[Case],
        subject: Subject,
        *,
        branch: Callable[[Case], Case | None],
        over: Callable[[], None],
        dies: Callable[[], None],
        keeps: bool = False,
    ) -> None:
        self.subject = subject
        self._keeps = keeps
        self.folder: Path | None = None
        self.waiting = list(cases)
        """Cases whose moment has not come."""
        self._case: Case | None = None
        self._branch = branch
        self._over = over
        self._program = Program(dies)
        self._broke_at: float | None = None
        self._seen_at: float | None = None
        self._stops_at = inf
        self._controlled_until = inf
        self._running_from: float | None = None
        self._felt = Felt(subject)
        self._said: list[str] = []
        self._stage: Stage
        self._rehearsal: RehearsalStage | None = None
        self._is_built = False
        self._unwritten: list[Break] = []
        self._refused = ""

    # What the run tells ------------------------------------------------------------------

    def rehearsing(self, rig: Rig) -> None:
        """Put the rehearsal on a stage of its own."""
        clock = cast("PausableClock", rig.clock)
        self._stage = self._rehearsal = RehearsalStage(clock, self._program)
        clock.world = self._stage  # type: ignore[assignment]
        for case in self.waiting:
            self._stage.cue(case.after, partial(self._come, case, case.after))

    def built(self, rig: Rig) -> None:
        """Put the world on the stage."""
        clock = cast("PausableClock", rig.clock)
        if self._rehearsal is not None:
            self._rehearsal.finish()
        self._stage = clock.world = Stage(clock, self._program)  # type: ignore[assignment]
        self._is_built = True
        if self._case is not None:  # it was broken while the run was rehearsed
            self._broke_at = 0.0
            end = self.subject.connecting + _lead_in() + _horizon(self._case)
            self._stage.cue(end, self._stage.interrupt)
        self._described = describe_truth(rig.truth_columns, self._stage.world.plant.powered())
        self._columns = [column.name for column in self._described]
        for case in self.waiting:
            if case.moment is Moment.CONNECT:
                self._stage.cue_before(case.after, partial(self._come, case, case.after))

    def employed(self, controller: AnyController) -> AnyController:
        """Have the loop run a controller that can be spoilt."""
        return _Spoilt(controller, self._program, self._feel)

    def started(self, path: Path) -> None:
        """Take note of the run folder."""
        self.folder = path
        self._program.log = path / LOG
        for item in self._unwritten:
            self._note(item)

    def said(self, sentence: str) -> None:
        """Take note of what the operator is told beside the message."""
        self._said.append(sentence)

    def moved(self, state: RigState, t: float | None) -> None:
        """Set the cues of the phase that begins."""
        now, start = self._stage.clock.now(), self._running_from
        if state is RigState.RUNNING:
            self._running_from = now
            for case in self.waiting:
                if case.moment is not Moment.CONNECT:
                    at = now + _comes_at(case)
                    self._stage.cue_before(at, partial(self._come, case, at))
        elif state is RigState.STOPPING and self._case is not None:
            self._stops_at = now
            if self._case.moment is Moment.RELEASE:
                self._stage.cue(now + self._case.after, self._break_first)
        elif state in (RigState.IDLE, RigState.FAULT):
            at = now if t is None or start is None else start + t
            if start is not None:
                self._controlled_until = min(self._controlled_until, at)
            if state is RigState.FAULT and self._seen_at is None:
                self._seen_at = at

    # What happens ------------------------------------------------------------------------

    def _come(self, case: Case, at: float) -> None:
        """Go two ways: here the case begins at a world time (s), in the other it has been."""
        self.waiting.remove(case)
        performed = self._branch(case)
        if performed is None:
            if not self.waiting:
                self._over()
            return
        self._case = performed
        self.waiting.clear()  # the others are the other process's
        self._stage.forget_cues()
        self._stage.cue(at, self._begin)

    def _begin(self) -> None:
        case, stage = self._case, self._stage
        if case is None:
            return
        if case.moment is Moment.RELEASE:
            stage.interrupt()
        elif case.moment is Moment.STOP:
            stage.interrupt()
            stage.interrupt()
            stage.cue(stage.world.time + case.after, self._break_first)
        else:
            self._break_first()

    def _break_first(self) -> None:
        case = self._case
        if case is None:
            return
        now = self._broke_at = self._stage.world.time
        if case.then is not None:
            self._stage.cue(now + case.then_after, self._break_second)
        if case.moment is not Moment.REHEARSAL:
            lead_in = _lead_in() if case.moment is Moment.CONNECT else 0.0
            end = now + lead_in + case.then_after + _horizon(case)
            self._stage.cue(end, self._stage.interrupt)
        self._make(case.first)

    def _feel(self) -> None:
        """Count the time of what spoils the law from the first command that is spoilt."""
        now = self._stage.world.time
        if self._felt.spoil(now):
            self._broke_at = now

    def _break_second(self) -> None:
        if self._case is not None and self._case.then is not None:
            self._make(self._case.then)

    def _make(self, item: Break) -> None:
        stage = self._stage
        number = len(self._felt)
        self._felt.make(item, stage.world.time)
        stage.changed = lambda: self._felt.change(number, stage.world.time)
        self._note(item)
        try:
            end = item.row.apply(stage, item.place(self.subject), item.sizes)
        except ValueError as error:  # of the simulation: nothing that the program did
            if isinstance(error, OSError):  # of a stream that is gone, as it was meant to be
                raise
            self._refused = f"the simulation refuses {item.kind} at {item.where}: {error}"
            return
        if end is not None and item.lasts < float("inf"):
            stage.cue(stage.world.time + item.lasts, end)

    def _note(self, item: Break) -> None:
        """Write into the run's events what was done to it."""
        if self.folder is None:
            self._unwritten.append(item)
            return
        start = self._running_from
        note_break(self.folder, item, None if start is None else self._stage.world.time - start)

    @property
    def place(self) -> str:
        """The path of the run folder; empty: there is none."""
        return "" if self.folder is None else str(self.folder.resolve())

    # What came of it ---------------------------------------------------------------------

    def end(self, code: int | None, message: str) -> Verdict:
        """Watch the world on, and judge.

        Parameters
        ----------
        code : int or None
            Of the program; None if it was killed.
        message : str
            What the operator was told.
        """
        assert self._case is not None
        self._program.free_disk()
        if not self._is_built:  # no device was ever opened, so nobody can have been hurt
            ending = CaseEnding(code, message, self._broke_at, None)
            return give_verdict(self._case, ending, self.subject)
        ended_at = self._stage.world.time
        self._stage.watch_on(AFTERMATH)
        # A dead program says nothing; what its devices do of themselves has to be done by then.
        safe_from = ended_at if code is not None else ended_at + AFTERMATH - 0.1
        truth, clock = self._stage.truth, clock_of(self._running_from)
        times, rows = (np.array(values) for values in truth)
        plight = partial(
            plight_of, subject=self.subject, columns=self._columns, truth=truth,
            ended_at=ended_at, controlled_until=self._controlled_until,
        )  # fmt: skip
        made_at = [*self._felt.made_at, *[None] * len(self._case.breaks)]  # a second may not come
        forgiven = {
            name
            for item, at in zip(self._case.breaks, made_at, strict=False)
            for name in item.row.forgives | item.row.excuses(plight(item, broke_at=at))
        }
        found = partial(
            judge, self.subject.hazards, self._columns, times, rows, safe_from=safe_from
        )
        violations = found(forgiven=forgiven)
        told = " ".join((message, *self._said))
        wrong = [v for v in violations if not _is_confessed(v, told)]
        excused = [v for v in found() if v.hazard in forgiven] if forgiven else []
        rehearsed = self._case.moment is Moment.REHEARSAL  # which has a clock of its own
        until = min(ended_at, self._controlled_until)
        felt_at = self._felt.shown(self._columns, times, rows, until, self._stops_at)
        ending = CaseEnding(
            code, message, clock.or_never(self._broke_at),
            None if rehearsed else clock.or_never(self._seen_at),
            tuple(v._replace(t=clock.of(v.t)) for v in wrong),
            tuple(clock.or_never(at) for at in felt_at),
            clock.since,
            tuple(v._replace(t=clock.of(v.t)) for v in excused),
        )  # fmt: skip
        verdict = give_verdict(self._case, ending, self.subject)
        if len(self._felt) < len(self._case.breaks):  # what did not happen was not ridden through
            verdict = verdict.missed()
        if self._refused:
            verdict = verdict.broken(self._refused)
        if self.folder is not None and (verdict.failed or self._keeps):
            whole = WholeTruth(self._described, truth, self.subject.hazards, ended_at)
            keep_case(self.folder, verdict, whole, clock)
            verdict = replace(verdict, folder=self.place)
        return verdict


def plight_of(
    item: Break,
    subject: Subject,
    columns: Sequence[str],
    truth: Truth,
    broke_at: float | None,
    ended_at: float,
    controlled_until: float = inf,
) -> Plight:
    """Return how the rig was when its faults began, which may be after the program's end.

    Parameters
    ----------
    item : Break
        What breaks.
    subject : Subject
        The rig.
    columns : sequence of str
        Of the truth.
    truth : Truth
        From the start on.
    broke_at : float or None
        When it did, s; None if it did not.
    ended_at : float
        When the program ended or died, s.
    controlled_until : float
        When its loop did, s: what breaks afterwards, no cycle sees.
    """
    at = ended_at if broke_at is None else broke_at
    first, last = (max(bisect_right(truth.times, t) - 1, 0) for t in (at, max(at, ended_at)))
    place = item.place(subject)
    moved = 0.0
    if place.axis in columns:
        column = columns.index(place.axis)
        # What begins to move just before the end could not be seen any more.
        seen = bisect_right(truth.times, truth.times[last] - item.row.within)
        way = [row[column] for row in truth.rows[first : max(seen, first + 1)]]
        moved = max(way) - min(way)
    power = [columns.index(f"powered_{a}") for a in place.names[:1] if f"powered_{a}" in columns]
    limp = any(row[column] == 0.0 for row in truth.rows[first:] for column in power)
    values = dict(zip(columns, truth.rows[first], strict=True))
    left = min(ended_at, controlled_until) - at
    return Plight(subject, place, item.sizes, values, left, moved, limp)


def _is_confessed(violation: Violation, told: str) -> bool:
    """Return whether the operator was told that this chamber is not safe: no false promise.

    Or what it held when it was last heard of, and that nobody knows since.
    """
    _, _, channel = violation.column.partition("_")
    said = rf"(?<!\w){re.escape(channel)} (still holds|held) "  # antagonist is not agonist
    return violation.hazard == ENERGY_LEFT and re.search(said, told) is not None


def _horizon(case: Case) -> float:
    """Return how long a run may go on after its last fault, s.

    What only motion shows is not waited for: the stop comes, which moves most things.
    """
    rows = [item.row for item in case.breaks]
    waits = [row.filling for row in rows if case.moment is Moment.ENERGISE]
    return max([HORIZON, *waits, *(row.within for row in rows if not row.in_motion)])


def _lead_in() -> float:
    timings = Timings()
    return timings.energise + timings.approach


def _comes_at(case: Case) -> float:
    """Return when the case's own way begins, s after the loop did."""
    timings = Timings()
    if case.moment in (Moment.ENERGISE, Moment.CALIBRATION):
        return case.after
    if case.moment is Moment.APPROACH:
        return timings.energise + case.after
    if case.moment is Moment.RUN:
        return _lead_in() + case.after
    return _lead_in() + random.Random(case.seed).uniform(0.0, RUN_SHARE)
