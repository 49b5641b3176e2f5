"""One experiment on one rig, from preflight to the report."""

import contextlib
import shlex
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

from rig.assembly import Backend, Rig, build_rig
from rig.assembly.frame_recording import FORMATS, FRAMES, convert_frames, make_frame_log
from rig.config import dump_resolved
from rig.config.calibration_state import calibration_states
from rig.experiment.metrics import Metric, all_passed, evaluate, evaluation_as_json
from rig.experiment.plan import Plan
from rig.experiment.rehearsal import rehearse
from rig.experiment.watcher import Watcher
from rig.hal import Clock, DeviceError, RigError
from rig.run_folder import EVALUATION, RunFolder, RunStatus
from rig.runtime.cycle import RUN_COLUMNS, TIMING_COLUMNS
from rig.runtime.log import read_log
from rig.runtime.loop import Loop, Outcome
from rig.runtime.phases import Phase, Timings
from rig.runtime.realtime import real_time
from rig.runtime.recorder import LogRecorder
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

EXIT_OK, EXIT_MISSED, EXIT_PREFLIGHT, EXIT_FAULT, EXIT_INTERRUPTED = 0, 1, 3, 4, 130


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
    """

    path: Path
    status: RunStatus
    exit_code: int
    message: str | None
    metrics: tuple[Metric, ...]


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
        Draw figures and write the report.
    frames : str, optional
        Record the CAN buses, in one of `rig.assembly.frame_recording.FORMATS`.
    heed_calibrations : bool
        Refuse hardware whose calibration does not hold; False: it is being mended.

    Returns
    -------
    Result
        Whatever happened on the rig is in it.

    Raises
    ------
    ConfigurationError
        The run folder cannot be made, or the profile does not run on this backend.
    DeviceError
        On hardware: a calibration does not hold; with the command that would mend it.
    """
    watcher = watcher or Watcher()
    doubts = _check_calibrations(plan, backend) if heed_calibrations else []
    if not backend.is_simulated:
        rehearse(plan)
    frame_log = None if frames is None else make_frame_log(plan.profile, backend)
    rig = build_rig(plan.profile, backend, on, frame_log)
    try:
        watcher.built(rig)
        folder = _create_folder(plan, backend, on, out, overrides, frames)
        if frame_log is not None:
            frame_log.start(folder.path / f"{FRAMES}.{FORMATS[0]}")
    except BaseException:
        rig.close()
        raise
    watcher.started(folder.path)
    for sentence in doubts:
        watcher.said(sentence)
        _Events(folder)(None, "calibration", sentence, {})
    stopwatch = _Stopwatch(rig.clock)
    with StopRequests() as stop:
        status, code, message = _run(plan, rig, folder, watcher, stop, stopwatch)
        stop.shield()  # what is left is bookkeeping; it is not to be torn either
        counts: dict[str, Any] = {"buses": rig.statistics()}
        if frame_log is not None:
            counts["frames"] = {"recorded": frame_log.count, "lost": frame_log.lost}
            _keep_frames(plan, folder, watcher, frame_log.close(), str(frames))
        metrics = _finish(plan, folder, status, stopwatch)
        if backend.is_simulated and stopwatch.facts:
            watcher.said(str(stopwatch))
        if status is RunStatus.OK and not all_passed(metrics):
            status, code = RunStatus.FAILED, EXIT_MISSED
        folder.finish(status, code, message, counts)
    if report:
        from rig.report.regenerate import write_report

        write_report(folder.path)
    return Result(folder.path, status, code, message, tuple(metrics))


def _check_calibrations(plan: Plan, backend: Backend) -> list[str]:
    """Return what is doubtful in a simulation; on hardware it is refused."""
    doubts = []
    for state in calibration_states(plan.profile, datetime.now(UTC).date()):
        if state.problems and backend is Backend.HARDWARE:
            raise DeviceError(state.name, state.sentence)
        if state.problems:
            doubts.append(f"{state.name}: {state.sentence}")
    return doubts


def _create_folder(
    plan: Plan,
    backend: Backend,
    on: str | None,
    out: Path,
    overrides: Sequence[str],
    frames: str | None,
) -> RunFolder:
    experiment, profile = plan.experiment, plan.profile
    command = ["rig", "run", experiment.name, "--on", on or backend.value]
    for option in overrides:
        command += ["--set", option]
    if frames is not None:
        command.append(f"--frames={frames}")
    calibrations = {
        f"calibration/{path.name}": path.read_text(encoding="utf-8")
        for path in profile.files
        if path.parent.parent.name == "calibration"
    }
    data_sheets = {
        f"eds/{name}.eds": _text_of(entry.eds)
        for name, entry in profile.devices.items()
        if entry.eds is not None
    }
    folder = RunFolder.create(
        out,
        experiment.name,
        backend.value,
        inputs={
            "profile.yaml": dump_resolved(profile),
            "experiment.yaml": dump_resolved(experiment),
            **calibrations,
            **data_sheets,
        },
        seed=profile.simulation.seed if backend.is_simulated else None,
        command=[shlex.join(command)],
    )
    folder.write_json(
        EVALUATION,
        evaluation_as_json(
            plan.motion.segments,
            experiment.metrics,
            experiment.figures,
            plan.motion.facts,
            profile.mechanism,
        ),
    )
    return folder


def _text_of(path: Path) -> str:
    content = path.read_bytes()
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:  # most tools for EDS files write Latin-1
        return content.decode("latin-1")


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
        _Events(folder)(None, "frames", trouble, {})


def _run(
    plan: Plan,
    rig: Rig,
    folder: RunFolder,
    watcher: Watcher,
    stop: StopRequests,
    stopwatch: "_Stopwatch",
) -> tuple[RunStatus, int, str | None]:
    """Connect, arm, loop; return status, exit code and what ended it early."""
    events = _Events(folder)
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
            stack.callback(stop.shield)  # first on the way out: closing is not to be torn
            states.move(RigState.IDLE)
            loop = _make_loop(plan, rig, states, watcher)
            columns = (
                *RUN_COLUMNS,
                *rig.mechanism.columns,
                *[column for device in rig.devices.values() for column in device.log_columns],
                *TIMING_COLUMNS,
                *rig.truth_columns,
            )
            priority = 0 if rig.backend.is_simulated else plan.profile.loop.priority
            with (
                LogRecorder(folder.log_path, columns) as recorder,
                real_time(priority, plan.profile.loop.cpu) as refused,
            ):
                for sentence in refused:
                    watcher.said(sentence)
                    events(None, "real-time", sentence, {})
                rig.arm(torque=plan.motion.has_torque)
                energised = True
                with stopwatch:
                    outcome = loop.run(
                        plan.motion,
                        recorder=recorder,
                        events=events,
                        stop=stop,
                        timings=Timings(approach=plan.experiment.approach),
                        progress=watcher.progressed,
                    )
        held = rig.mechanism.pose_held() if outcome.fault is not None else None
        if held:
            watcher.said(held)
            events(loop.t, "hold", held, {})
        return _judge(outcome, loop.t, events)
    except KeyboardInterrupt:
        return RunStatus.ABORTED, EXIT_INTERRUPTED, "interrupted before the rig was energised"
    except RigError as error:
        states.latch_fault(error)
        events(None, "fault", str(error), {"type": type(error).__name__})
        if energised:
            return RunStatus.FAULTED, EXIT_FAULT, str(error)
        return RunStatus.FAULTED, EXIT_PREFLIGHT, str(error)


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
        truth=rig.truth,
    )


def _judge(
    outcome: Outcome, t: float | None, events: "_Events"
) -> tuple[RunStatus, int, str | None]:
    fault = outcome.fault
    if fault is not None:
        events(t, "fault", str(fault), {"type": type(fault).__name__})
        if not isinstance(fault, RigError | OSError):
            raise fault  # a bug of ours: the rig is safe by now, and the traceback is wanted
        return RunStatus.FAULTED, EXIT_FAULT, str(fault)
    if outcome.stopped:
        how = "stopped" if outcome.stopped == 1 else "stopped at once"
        return RunStatus.ABORTED, EXIT_INTERRUPTED, f"{how} by the operator, made safe"
    return RunStatus.OK, EXIT_OK, None


def _finish(
    plan: Plan, folder: RunFolder, status: RunStatus, stopwatch: "_Stopwatch"
) -> list[Metric]:
    """Write metrics and timing of whatever was recorded; return the metrics."""
    from rig.report.timing import summarise_timing

    if not folder.log_path.exists():
        return []
    log = read_log(folder.log_path)
    if len(log.cycle):
        folder.write_timing(summarise_timing(log) | stopwatch.facts)
    if status is not RunStatus.OK:
        return []
    metrics = evaluate(
        log,
        plan.motion.segments,
        plan.experiment.metrics,
        plan.motion.facts,
        plan.profile.mechanism,
    )
    folder.write_metrics(metrics)
    return metrics


class _Stopwatch:
    """Takes the loop's time by its own clock and by the wall's, however it ends."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._took = self._covered = 0.0

    def __enter__(self) -> None:
        self._took, self._covered = -perf_counter(), -self._clock.now()

    def __exit__(self, *_: object) -> None:
        self._took += perf_counter()
        self._covered += self._clock.now()

    @property
    def facts(self) -> dict[str, float]:
        """How long the loop took, s, and how many times real time that is."""
        return {"took": self._took, "speed": self._covered / self._took} if self._took else {}

    def __str__(self) -> str:
        factor = self._covered / self._took if self._took else 0.0
        return f"{self._covered:.1f} s took {self._took:.1f} s: {factor:.3g} times real time"


class _Events:
    """Writes events; a full disk must not keep the rig from being made safe."""

    def __init__(self, folder: RunFolder) -> None:
        self._folder = folder

    def __call__(self, t: float | None, kind: str, message: str, data: dict[str, Any]) -> None:
        with contextlib.suppress(RigError):
            self._folder.record_event(t, kind, message, **data)


__all__ = ["Phase", "Result", "run_experiment"]
