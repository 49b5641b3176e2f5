"""One experiment on one rig, from preflight to the report."""

import contextlib
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from rig.assembly import Backend, Rig, build_rig
from rig.assembly.channels import channels_of
from rig.assembly.contract_check import whose_bug
from rig.assembly.frame_recording import FORMATS, FRAMES, convert_frames, make_frame_log
from rig.commissioning.permission import as_commissioned
from rig.config.calibration_state import sentences_of_bases
from rig.config.records import sentences_of_records
from rig.experiment.by_hand import draw, telling_where
from rig.experiment.ending import (
    EXIT_FAULT,
    EXIT_INTERRUPTED,
    EXIT_OK,
    EXIT_PREFLIGHT,
    ClosedBooks,
    Ending,
    broken_contract,
    bug_of,
    fault_of,
    say_for_rig,
)
from rig.experiment.events import Events
from rig.experiment.fault_latch import FaultLatch
from rig.experiment.fitness import refuse_unfit
from rig.experiment.hindsight import Said, after_run
from rig.experiment.injected import faults_that_came, faults_that_never_came
from rig.experiment.kept_traceback import keep_traceback
from rig.experiment.metrics import Metric, all_passed
from rig.experiment.new_folder import create_folder, log_columns
from rig.experiment.permission import check_permitted
from rig.experiment.plan import Plan
from rig.experiment.post_mortem import whose_value
from rig.experiment.rehearsal import rehearse
from rig.experiment.results import write_results
from rig.experiment.stopwatch import Stopwatch
from rig.experiment.watcher import Watcher
from rig.hal import RigError
from rig.hal.hindsight import FLAWS
from rig.installation import need
from rig.report.ready import ReadyReporter
from rig.run_facts import RunStatus
from rig.run_folder import RunFolder
from rig.runtime.loop import Loop, Outcome
from rig.runtime.phases import Timings
from rig.runtime.realtime import real_time
from rig.runtime.recorder import LogRecorder
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests


class Result(NamedTuple):
    """The end of a run, with its folder and metrics.

    Parameters
    ----------
    path : Path
        The run folder.
    status : RunStatus
        As in its manifest.
    exit_code : int
        Of the command.
    message : str or None
        What ended it early.
    metrics : tuple of Metric
        Empty if it did not get far enough.
    unmeasured : tuple of RigError
        What the measures that came with the plan failed by; the run is none the worse for it.
    bug : BaseException, optional
        What ended it, if that was a bug, ours or of other code.
    """

    path: Path
    status: RunStatus
    exit_code: int
    message: str | None
    metrics: tuple[Metric, ...]
    unmeasured: tuple[RigError, ...] = ()
    bug: BaseException | None = None


def run_experiment(
    plan: Plan,
    backend: Backend,
    out: Path,
    *,
    on: str | None = None,
    overrides: Sequence[str] = (),
    watcher: Watcher | None = None,
    report: bool = True,
    frames: str | None = None,
    heed_calibrations: bool = True,
    stop: StopRequests | None = None,
    rehearses: bool = False,
    is_permitted: bool = False,
    command: Sequence[str] = (),
    uncommissioned: str | None = None,
    raises: bool = True,
) -> Result:
    """Run an experiment and leave a run folder.

    Parameters
    ----------
    plan : Plan
        Checked.
    backend : Backend
        What to run it on.
    out : Path
        Where run folders live.
    on : str, optional
        Other CAN interfaces than the profile's, see `build_rig`.
    overrides : sequence of str
        The options that shaped the plan; recorded so that the run can be repeated.
    watcher : Watcher, optional
        Is told what happens.
    report : bool
        Draw figures and write the report, unless somebody ended the run.
    frames : str, optional
        Record the CAN buses, in one of `rig.assembly.frame_recording.FORMATS`.
    heed_calibrations : bool
        Refuse hardware whose calibration does not hold, or that `refuse_unfit` refuses; False: it
        is being calibrated.
    stop : StopRequests, optional
        By which another thread may ask for the end.
    rehearses : bool
        Rehearse a simulated run as well, although nothing stalls in virtual time.
    is_permitted : bool
        The plan was tried with frozen setpoints before the operator was asked.
    command : sequence of str
        The command line that runs it again; default: ``rig run`` with the experiment's name.
    uncommissioned : str, optional
        Why a rig that is not commissioned has all of its speed and effort on hardware.
    raises : bool
        Raise the bug that ended it, for its traceback; False: it is in the result.

    Returns
    -------
    Result
        Whatever happened on the rig is in it.

    Raises
    ------
    ConfigurationError
        The run folder cannot be made, or the profile does not run on this backend.
    DeviceError
        On hardware: a calibration does not hold, a fault is latched, or `refuse_unfit` refuses it.
    ModuleNotFoundError
        A report is wanted, and what draws it is not installed.
    """
    if report:
        need("matplotlib")
    watcher = watcher or Watcher()
    doubts = check_permitted(plan, backend, on, heed_calibrations=heed_calibrations)
    notes: Sequence[str] = () if uncommissioned is None else (uncommissioned,)
    if heed_calibrations:
        doubts += [*sentences_of_bases(plan.profile), *sentences_of_records(plan.profile)]
        plan, notes = as_commissioned(plan, backend, uncommissioned)
    latch = FaultLatch.of(plan.profile, on) if backend is Backend.HARDWARE else None
    is_ours = stop is None  # then each request is a signal
    stop = stop or StopRequests()
    with ReadyReporter(ahead=report and backend.is_simulated) as reporter:
        with stop:
            if backend is Backend.HARDWARE and heed_calibrations and not is_permitted:
                refuse_unfit(plan, watcher.said)
            if rehearses or not backend.is_simulated:
                rehearse(plan, watcher)
            frame_log = None if frames is None else make_frame_log(plan.profile, backend)
            rig = build_rig(plan.profile, backend, on, frame_log)
            stop.shield()  # a folder that is half made could not tell how the run ended
            with contextlib.ExitStack() as stack:
                stack.callback(rig.close)
                watcher.built(rig)
                folder = create_folder(plan, backend, on, out, overrides, frames, command)
                stack.enter_context(telling_where(folder.path, watcher))
                stack.enter_context(ClosedBooks(folder, stop))
                stop.expose()
                if frame_log is not None:
                    frame_log.start(folder.path / f"{FRAMES}.{FORMATS[0]}")
                rig.show_in(folder.path)
                watcher.started(folder.path)
                watcher.recording(Events(folder))
                for kind, sentences in (("commissioning", notes), ("calibration", doubts)):
                    for sentence in sentences:
                        watcher.said(sentence)
                        Events(folder)(None, kind, sentence, {})
                stopwatch = Stopwatch(rig.clock)
                ending = _run(plan, rig, folder, watcher, stop, stopwatch, latch)
                stop.shield()  # what is left is bookkeeping; it is not to be torn either
                latched = None if latch is None else latch.settle(folder.path, ending)
                if latched is not None:
                    watcher.said(latched)
                counts: dict[str, Any] = {"buses": rig.statistics()}
                if frame_log is not None:
                    counts["frames"] = frame_log.facts(rig.clock)
                    _keep_frames(plan, folder, watcher, frame_log.close(), str(frames))
                metrics, unmeasured, ending = write_results(plan, folder, ending, stopwatch)
                for error in unmeasured:
                    Events(folder)(None, "measure", str(error), {})
                if backend.is_simulated and stopwatch.facts:
                    watcher.said(str(stopwatch))
                ending = ending.judged(passed=all_passed(metrics))
                if ending.bug is not None:
                    keep_traceback(folder.path, ending.bug)
                _close(folder, ending, counts, watcher)
        if ending.bug is not None and raises:
            raise ending.bug  # the rig is safe by now, and the traceback is wanted
        is_late = stop.count > stop.heard  # it came when the loop had ended
        if report and ending.bug is None:
            by_hand = is_late or ending.status is RunStatus.ABORTED
            draw(reporter, folder.path, watcher, by_hand=by_hand)
        if is_late and is_ours and ending.status in (RunStatus.OK, RunStatus.FAILED):
            raise KeyboardInterrupt  # as after these lines: nobody is to go on to something else
    return Result(
        folder.path, ending.status, ending.code, ending.message, tuple(metrics), tuple(unmeasured),
        ending.bug,
    )  # fmt: skip


def _close(folder: RunFolder, ending: Ending, counts: dict[str, Any], watcher: Watcher) -> None:
    """Close the books; the run has ended as it has, even if nobody can write that down."""
    try:
        folder.finish(ending.status, ending.code, ending.message, counts)
    except RigError as error:
        watcher.said(f"{error}; this run will be taken for one whose process died")


def _keep_frames(
    plan: Plan, folder: RunFolder, watcher: Watcher, trouble: str | None, kind: str
) -> None:
    """Give the recorded frames the format that was asked for, now that the rig is safe."""
    if trouble is None:
        try:
            convert_frames(folder.path / f"{FRAMES}.{FORMATS[0]}", kind, plan.profile)
        except (OSError, ValueError) as error:
            trouble = f"the frames stay in candump's format: {error}"
    if trouble is not None:
        watcher.said(trouble)
        Events(folder)(None, "frames", trouble, {})


def _run(
    plan: Plan,
    rig: Rig,
    folder: RunFolder,
    watcher: Watcher,
    stop: StopRequests,
    stopwatch: Stopwatch,
    latch: FaultLatch | None,
) -> Ending:
    """Connect, arm, loop; return how it ended."""
    events = Events(folder)
    flaws: list[str] = []

    def noted(t: float | None, kind: str, message: str, data: dict[str, Any]) -> None:
        events(t, kind, message, data)
        if kind == "stop":  # of a stop that was not as orderly as it was meant to be
            watcher.said(message)
            flaws.append(message)

    loop: Loop[Any, Any, Any] | None = None

    def on_change(old: RigState, new: RigState) -> None:
        t = None if loop is None else loop.t
        events(t, "state", f"{old} -> {new}", {"old": old, "new": new})
        watcher.moved(new, t)

    states = StateMachine(on_change)
    energised = False
    try:
        with contextlib.ExitStack() as stack:
            stack.enter_context(rig)
            stack.enter_context(stop.shielding_the_end())  # first on the way out
            states.move(RigState.IDLE)
            loop = _make_loop(plan, rig, states, watcher)
            priority = 0 if rig.backend.is_simulated else plan.profile.loop.priority
            stop.shield()  # of the collector's call-backs one would swallow it
            with (
                LogRecorder(folder.log_path, log_columns(rig)) as recorder,
                real_time(priority, plan.profile.loop.cpu) as refused,
                stop.shielding_the_end(),
            ):
                stop.expose()
                for sentence in refused:
                    watcher.said(sentence)
                    events(None, "real-time", sentence, {})
                if latch is not None:
                    latch.set(folder.path)
                rig.arm(torque=plan.motion.has_torque)
                energised = True
                with stopwatch:
                    outcome = loop.run(
                        plan.motion,
                        recorder=recorder,
                        events=noted,
                        stop=stop,
                        timings=Timings(approach=plan.experiment.approach),
                        progress=watcher.progressed,
                        progress_every=watcher.progress_every,
                    )
        if rig.backend.is_simulated and loop.phases is not None and loop.t is not None:
            broken, times = plan.profile.simulation.faults, (loop.phases.start, loop.t)
            for t, sentence, data in faults_that_came(broken, channels_of(plan.profile), *times):
                events(t, "injected", sentence, data)
            for sentence in faults_that_never_came(broken, *times):
                watcher.said(sentence)
                events(loop.t, "never", sentence, {})
        given_up = loop.t if loop.start is None else rig.clock.now() - loop.start
        watcher.working("measuring")
        said: list[Said] = [("unsafe", sentence, {}) for sentence in outcome.unsafe]
        said += after_run(rig, outcome.fault, folder.log_path)
        said = [(of, say_for_rig(what, plan.profile.argument), data) for of, what, data in said]
        for kind, sentence, data in said:
            watcher.said(sentence)
            events(given_up if kind == "unsafe" else loop.t, kind, sentence, data)
        blame = partial(whose_value, rig, plan, loop.phases)
        ending = _judge(outcome, loop.t, events, blame, plan.profile.argument)
        if ending.code == EXIT_OK and not folder.log_path.exists():
            lost = f"{folder.log_path} was removed while it was written: the record is lost"
            return Ending(RunStatus.FAULTED, EXIT_FAULT, lost)
        flaws += [sentence for kind, sentence, _ in said if kind in FLAWS]
        return ending._replace(flaw="; ".join(flaws))
    except (KeyboardInterrupt, SystemExit) as error:
        if whose_bug(error) is not None or isinstance(error, SystemExit):
            return _by_bug(error, None if loop is None else loop.t, events)
        when = "between two steps" if energised else "before the rig was energised"
        return Ending(RunStatus.ABORTED, EXIT_INTERRUPTED, f"interrupted {str(error) or when}")
    except RigError as error:
        states.latch_fault(error)
        events(None, "fault", str(error), {"type": type(error).__name__})
        return Ending(RunStatus.FAULTED, EXIT_FAULT if energised else EXIT_PREFLIGHT, str(error))
    except Exception as error:
        blamed = whose_value(rig, plan, None if loop is None else loop.phases, error)
        if blamed is None:
            if whose_bug(error) is None:
                raise
            return _by_bug(error, None if loop is None else loop.t, events)
        return broken_contract(blamed)


def _by_bug(error: BaseException, t: float | None, events: Events) -> Ending:
    """Return the ending of a run that a bug has ended beside its loop's own stop; it is noted."""
    ending = bug_of(error, t)
    events(t, "fault", str(ending.message), {"type": type(error).__name__})
    return ending


def _make_loop(plan: Plan, rig: Rig, states: StateMachine, watcher: Watcher) -> Loop[Any, Any, Any]:
    loop = plan.profile.loop
    rig.mechanism.attach(plan.controller, plan.motion)
    plan.motion.attach(rig.devices)
    return Loop(
        clock=rig.clock,
        period=loop.period,
        buses=tuple(rig.buses.values()),
        devices=tuple(rig.devices.values()),
        mechanism=rig.mechanism,
        controller=watcher.employed(plan.controller),
        states=states,
        max_missed=loop.max_missed,
        safe_within=loop.safe_within,
        truth=rig.truth,
    )


def _judge(
    outcome: Outcome,
    t: float | None,
    events: Events,
    blame: Callable[[BaseException], str | None],
    rig: str,
) -> Ending:
    fault = outcome.fault
    if fault is not None:
        ending = fault_of(fault, t).for_rig(rig)
        if ending.bug is not None and (sentence := blame(fault)) is not None:
            ending = broken_contract(sentence)
        events(t, "fault", str(ending.message), {"type": type(fault).__name__})
        for note in getattr(fault, "__notes__", ()):
            events(t, "explanation", note, {"type": type(fault).__name__})
        return ending
    if outcome.unsafe:
        unsafe = "not made safe: " + "; ".join(outcome.unsafe)
        return Ending(RunStatus.FAULTED, EXIT_FAULT, unsafe)
    if outcome.stopped:
        how = "stopped" if outcome.stopped == 1 else "stopped at once"
        return Ending(RunStatus.ABORTED, EXIT_INTERRUPTED, f"{how} by the operator, made safe")
    return Ending(RunStatus.OK, EXIT_OK)
