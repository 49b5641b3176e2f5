"""The cases of one experiment and one seed, performed one after the other in copies of a run."""

import os
import pickle
import select
import shutil
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from rig.assembly import REGISTRY, Backend
from rig.calibration.catalogue import pick
from rig.calibration.session import record
from rig.config import find_configs, load_profile
from rig.experiment.ending import ending_of
from rig.experiment.plan import load_plan
from rig.experiment.run import Result, run_experiment
from rig.faults.branch import Home, make_home
from rig.faults.case import Case, Moment
from rig.faults.counterfactual import borne_out, stopped_at_once
from rig.faults.performance import Performance
from rig.faults.subject import Subject
from rig.faults.verdict import MISSED, OK, OURS, CaseEnding, Verdict, give_verdict
from rig.hal import RigError
from rig.runtime.parent import die_with_parent

DEADLINE = 120.0
"""How long a case may take by the wall's clock, s: it hangs."""

Tell = Callable[[Verdict], None]


def perform_unit(
    cases: Sequence[Case],
    subject: Subject,
    out: Path,
    configs: Path | None,
    tell: Tell,
    *,
    keeps: bool = False,
) -> None:
    """Run an experiment once, and every case as a copy of it from its moment on; does not return.

    Parameters
    ----------
    cases : sequence of Case
        Of the same rig, experiment and seed.
    subject : Subject
        The rig.
    out : Path
        Where the folders go; those of cases in which nothing is wrong are removed.
    configs : Path, optional
        The folder of the configurations.
    tell : callable
        Takes each verdict.
    keeps : bool
        Keep all folders.
    """
    first = cases[0]
    shared = out / f"{first.folder}-shared"
    shutil.rmtree(shared, ignore_errors=True)
    home = make_home(shared)
    branch = _Branch(home, out, subject, tell, keeps=keeps)

    def over() -> None:
        shutil.rmtree(shared, ignore_errors=True)
        os._exit(0)

    performance = Performance(
        cases, subject, branch=branch.go, over=over,
        dies=lambda: branch.tell_end(None, "killed"), keeps=keeps,
    )  # fmt: skip
    branch.performance = performance
    try:
        result = _run(first, home.path, configs, performance)
    except (RigError, KeyboardInterrupt) as error:  # as the command line has them
        ending = ending_of(error)
        branch.tell_end(ending.code, ending.message or "")
    except Exception as error:  # a bug, or one that was injected: the command line's exit 70
        branch.tell_end(OURS, f"{type(error).__name__}: {error}")
    else:
        branch.tell_end(result.exit_code, result.message or "")


def _run(case: Case, out: Path, configs: Path | None, performance: Performance) -> Result:
    """Run the experiment of a case, or the first run that its calibration records."""
    options = [f"simulation.seed={case.seed}"]
    if case.moment is not Moment.CALIBRATION:
        plan = load_plan(case.experiment, options, rig=case.rig, configs=configs)
        return run_experiment(
            plan, Backend.VIRTUAL, out, watcher=performance, report=False,
            rehearses=case.moment is Moment.REHEARSAL,
        )  # fmt: skip
    profile = load_profile(case.rig, REGISTRY, options, find_configs(configs))
    (procedure,) = pick(profile, (case.experiment,))
    puts = iter([True])
    result, _ = record(
        procedure, profile, Backend.VIRTUAL, out, watcher=performance,
        place=lambda what: next(puts, False),
    )  # fmt: skip
    assert result is not None, "nothing was recorded before"
    return result


class _Branch:
    """The fork of a run at a case's moment, and the way back of its verdict."""

    def __init__(self, home: Home, out: Path, subject: Subject, tell: Tell, *, keeps: bool) -> None:
        self.performance: Performance
        self._home = home
        self._out = out
        self._subject = subject
        self._tell = tell
        self._keeps = keeps
        self._sender: int | None = None
        self._folder: Path

    def go(self, case: Case) -> Case | None:
        """Copy this process; return what the copy performs, and None here when it has ended.

        Once more where a hazard may have been inevitable: see `rig.faults.counterfactual`.
        """
        verdict = self._copy(case)
        if verdict is None:
            return case
        stopped = stopped_at_once(case, self._subject) if verdict.hazard else None
        if stopped is not None:
            witness = self._copy(stopped)
            if witness is None:
                return stopped
            shutil.rmtree(self._folder, ignore_errors=True)
            verdict = borne_out(verdict, witness)
            if not (verdict.failed or self._keeps):
                shutil.rmtree(self._out / case.folder, ignore_errors=True)
        self._tell(verdict)
        return None

    def _copy(self, case: Case) -> Verdict | None:
        """Copy this process; return None in the copy, and its verdict here when it has ended."""
        reader, writer = os.pipe()
        self._folder = self._out / case.folder
        shutil.rmtree(self._folder, ignore_errors=True)
        child = os.fork()
        if child == 0:
            die_with_parent()
            os.close(reader)
            self._sender = writer
            self._home.move(self._folder)
            return None
        os.close(writer)
        return _receive(reader, child) or no_verdict(case, self._subject, "it gave no verdict")

    def tell_end(self, code: int | None, message: str) -> None:
        """Tell the verdict of this process's case, and end it; nothing of the program is left."""
        if self._sender is not None:
            verdict = self.performance.end(code, message)
            if not (verdict.failed or self._keeps):
                shutil.rmtree(self._folder, ignore_errors=True)
            with os.fdopen(self._sender, "wb") as pipe:
                pickle.dump(verdict, pipe)
        else:  # without any fault it should not have ended before them
            for case in self.performance.waiting:
                if code in (OK, MISSED):
                    ending = CaseEnding(code, message, None, None)
                    self._tell(give_verdict(case, ending, self._subject).missed())
                else:
                    why = f"the run ended before it {message}".rstrip()
                    verdict = no_verdict(case, self._subject, why)
                    self._tell(replace(verdict, folder=self.performance.place))
        os._exit(0)


def _receive(reader: int, child: int) -> Verdict | None:
    """Return what a copy tells, or None if it says nothing or hangs."""
    with os.fdopen(reader, "rb") as pipe:
        ready, _, _ = select.select([pipe], [], [], DEADLINE)
        content = pipe.read() if ready else b""
    if not ready:
        os.kill(child, 9)
    os.waitpid(child, 0)
    return pickle.loads(content) if content else None


def no_verdict(case: Case, subject: Subject, why: str) -> Verdict:
    """Return the verdict of a case that gave none: never taken for a pass."""
    ending = CaseEnding(None, why, None, None)
    return give_verdict(case, ending, subject).broken(why)
