"""One case performed in a process of its own: the program as it is, on a stage that breaks."""

import json
import os
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn, cast

import numpy as np

from rig.assembly import Backend, Rig
from rig.experiment.plan import Plan, load_plan
from rig.experiment.run import Result, run_experiment
from rig.experiment.watcher import Watcher
from rig.faults.case import RUN_SHARE, Break, Case, Moment
from rig.faults.oracle import judge
from rig.faults.stage import PausableClock, Program, Stage
from rig.faults.subject import Subject
from rig.faults.verdict import OURS, Ending, Verdict, give_verdict
from rig.hal import Controller
from rig.run_folder import EVENTS, LOG
from rig.runtime.states import RigState

AFTERMATH = 1.5
"""How long the world is watched after the program has ended or died, s."""
HORIZON = 1.0
"""How long the run may go on after the last fault until it is asked to stop, s."""
TRUTH = "truth.npz"


class _Spoilt(Controller[Any, Any, Any]):
    """A controller whose commands the stage may spoil."""

    def __init__(self, inner: Controller[Any, Any, Any], program: Program) -> None:
        self._inner = inner
        self._program = program

    def reset(self, state: Any) -> None:
        """Start from the measured state."""
        self._inner.reset(state)

    def update(self, state: Any, reference: Any) -> Any:
        """Return the command, spoilt if it is to be."""
        command = self._inner.update(state, reference)
        spoils = self._program.spoils
        return command if spoils is None else spoils(command)


class Performance(Watcher):
    """A run that is watched and broken on cue.

    Parameters
    ----------
    case : Case
        What is to happen.
    subject : Subject
        The rig.
    on_death : callable
        Called when the program is killed, with the ending; does not return.
    """

    def __init__(
        self, case: Case, subject: Subject, on_death: Callable[["Performance"], NoReturn]
    ) -> None:
        self.case = case
        self.subject = subject
        self.folder: Path | None = None
        self.broke_at: float | None = None
        self.seen_at: float | None = None
        self._program = Program(lambda: on_death(self))
        self._running_from: float | None = None
        self._ended = False
        self.stage: Stage

    # What the run tells ------------------------------------------------------------------

    def built(self, rig: Rig) -> None:
        """Put the world on the stage."""
        clock = cast("PausableClock", rig.clock)
        self.stage = clock.world = Stage(clock, self._program)  # type: ignore[assignment]
        self._columns = [column.name.removeprefix("truth.") for column in rig.truth_columns]
        if self.case.moment is Moment.CONNECT:
            self.stage.cue(self.case.after, self._break_first)

    def employed(self, controller: Controller[Any, Any, Any]) -> Controller[Any, Any, Any]:
        """Have the loop run a controller that can be spoilt."""
        return _Spoilt(controller, self._program)

    def started(self, path: Path) -> None:
        """Take note of the run folder."""
        self.folder = path
        self._program.log = path / LOG

    def moved(self, state: RigState, t: float | None) -> None:
        """Set the cues of the phase that begins."""
        now, after = self.stage.clock.now(), self.case.after
        match state, self.case.moment:
            case RigState.RUNNING, _:
                self._running_from = now
                self._cue_run(now)
            case RigState.STOPPING, Moment.RELEASE:
                self.stage.cue(now + after, self._break_first)
            case RigState.FAULT, _ if self.seen_at is None:
                start = self._running_from
                self.seen_at = now if t is None or start is None else start + t

    def _cue_run(self, now: float) -> None:
        after, stage = self.case.after, self.stage
        starts = {Moment.ENERGISE: 0.0, Moment.APPROACH: 1.0, Moment.RUN: 3.0}
        match self.case.moment:
            case Moment.RELEASE:
                share = random.Random(self.case.seed).uniform(0.0, RUN_SHARE)
                stage.cue(now + 3.0 + share, stage.interrupt)
            case Moment.STOP:
                at = now + 3.0 + random.Random(self.case.seed).uniform(0.0, RUN_SHARE)
                stage.cue(at, stage.interrupt)
                stage.cue(at, stage.interrupt)
                stage.cue(at + after, self._break_first)
            case Moment.CONNECT:
                stage.cue(now + 3.0 + HORIZON, stage.interrupt)
            case moment:
                stage.cue(now + starts[moment] + after, self._break_first)

    # What happens ------------------------------------------------------------------------

    def _break_first(self) -> None:
        if self._ended:
            return
        self.broke_at = self.stage.world.time
        if self.case.then is not None:
            self.stage.cue(self.broke_at + self.case.then_after, self._break_second)
        if self.case.moment is not Moment.CONNECT:
            self.stage.cue(self.broke_at + self.case.then_after + HORIZON, self.stage.interrupt)
        self._make(self.case.first)

    def _break_second(self) -> None:
        if self.case.then is not None and not self._ended:
            self._make(self.case.then)

    def _make(self, item: Break) -> None:
        stage = self.stage
        self._note(item)
        end = item.row.apply(stage, item.place(self.subject), item.sizes)
        if end is not None and item.lasts < float("inf"):
            stage.cue(stage.world.time + item.lasts, end)

    def _note(self, item: Break) -> None:
        """Write into the run's events what was done to it."""
        if self.folder is None:
            return
        start = self._running_from
        t = None if start is None else self.stage.world.time - start
        data = {"fault": item.kind, "where": item.where, "magnitude": item.magnitude}
        if item.lasts < float("inf"):
            data["lasts"] = item.lasts
        event = {"t": t, "kind": "injected", "message": item.row.what, "data": data}
        with (self.folder / EVENTS).open("a", encoding="utf-8") as file:
            file.write(json.dumps(event) + "\n")

    # What came of it ---------------------------------------------------------------------

    def end(self, code: int | None, message: str) -> Verdict:
        """Watch the world on, and judge."""
        self._ended = True
        ended_at = self.stage.world.time
        self.stage.watch_on(AFTERMATH)
        # A dead program says nothing; what its devices do of themselves has to be done by then.
        safe_from = ended_at if code is not None else ended_at + AFTERMATH - 0.1
        times, rows = (np.array(values) for values in self.stage.truth)
        forgiven = {name for item in self.case.breaks for name in item.row.forgives}
        violations = judge(
            self.subject.hazards, self._columns, times, rows,
            safe_from=safe_from, forgiven=forgiven,
        )  # fmt: skip
        ending = Ending(code, message, self.broke_at, self.seen_at, tuple(violations))
        verdict = give_verdict(self.case, ending, self.subject)
        if verdict.failed and self.folder is not None:
            np.savez_compressed(self.folder / TRUTH, columns=self._columns, t=times, truth=rows)
        return verdict


def load_case_plan(case: Case, configs: Path | None) -> Plan:
    """Load what a case runs."""
    seed = f"simulation.seed={case.seed}"
    return load_plan(case.experiment, [seed], rig=case.rig, configs=configs)


def perform(
    case: Case, subject: Subject, out: Path, configs: Path | None, tell: Callable[[Verdict], None]
) -> None:
    """Run a case to its end, or to that of this process, and tell the verdict.

    Parameters
    ----------
    case, subject
        What happens to what.
    out : Path
        Where the run folder goes.
    configs : Path, optional
        The folder of the configurations.
    tell : callable
        Takes the verdict; called once.
    """

    def die(performance: Performance) -> NoReturn:
        tell(performance.end(None, "killed"))
        os._exit(0)

    plan = load_case_plan(case, configs)
    performance = Performance(case, subject, die)
    try:
        result = run_experiment(plan, Backend.VIRTUAL, out, watcher=performance, report=False)
    except Exception as error:  # a bug, or one that was injected: the command line's exit 70
        result = Result(out, None, OURS, f"{type(error).__name__}: {error}", ())  # type: ignore[arg-type]
    tell(performance.end(result.exit_code, result.message or ""))
