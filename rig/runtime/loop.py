"""The fixed-rate cycle that every rig runs on every backend.

One cycle: drain the buses, read one frozen state, check it, update the controller, limit,
write, record, and sleep to an absolute deadline (``start + k * period``). A cycle that comes
late skips ticks; it never bursts to catch up. Whatever goes wrong, every device is made safe,
and told so for several cycles, before anything else happens.
"""

import contextlib
import math
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any, Generic, NamedTuple, Protocol

from rig.hal import Clock, CyclicBus, Device, LimitExceeded, LoopStalled
from rig.hal.columns import Column
from rig.hal.controller import Controller
from rig.hal.mechanism import Command, Margin, Mechanism, Reference, State
from rig.hal.motion import Motion
from rig.runtime.phases import Phase, Phases, Timings
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests
from rig.runtime.stop_recording import StopRecording

SAFE_CYCLES = 5
"""How many cycles the safe setpoints are repeated: one lost frame must not matter."""


class Progress(NamedTuple):
    """What a progress line needs."""

    phase: Phase
    t: float
    duration: float
    margin: Margin
    missed: int


class Outcome(NamedTuple):
    """How a run ended.

    Parameters
    ----------
    cycles : int
        Cycles that were run and recorded.
    missed : int
        Ticks that were skipped because a cycle came late.
    stopped : int
        Requests to stop that came: 0 ran to its end, 1 orderly stop, 2 or more at once.
    fault : Exception or None
        What ended it early.
    """

    cycles: int
    missed: int
    stopped: int
    fault: Exception | None


class Recorder(Protocol):
    """Where each cycle goes."""

    def write(self, cycle: int, t: float, row: Sequence[float]) -> None:
        """Append one cycle; it is with the operating system when this returns."""
        ...


RUN_COLUMNS = (
    Column("phase", "", "0 approach, 1 run, 2 stop"),
    Column("reference.time", "s", "time since the reference started; negative before"),
)
TIMING_COLUMNS = (
    Column("timing.lateness", "s", "how late the cycle started"),
    Column("timing.slack", "s", "time left of the period after the work"),
    Column("timing.receive", "s", "buses drained and decoded"),
    Column("timing.read", "s", "state assembled and checked"),
    Column("timing.control", "s", "reference, estimator, controller, limits"),
    Column("timing.transmit", "s", "setpoints encoded and sent"),
    Column("timing.record", "s", "row written, in the cycle before"),
)


class Loop(Generic[State, Reference, Command]):
    """Runs one motion on one rig.

    Parameters
    ----------
    clock : Clock
        Virtual or real.
    period : float
        s.
    buses, devices : sequence
        Everything that is exchanged, checked and made safe.
    mechanism : Mechanism
        State, limits and log columns.
    controller : Controller
        What is updated once a cycle.
    states : StateMachine
        IDLE on entry; IDLE or FAULT on return.
    max_missed : int
        So many ticks missed in a row are a fault.
    truth : callable, optional
        In simulation: the plant's true values, appended to each row.
    """

    def __init__(
        self,
        *,
        clock: Clock,
        period: float,
        buses: Sequence[CyclicBus],
        devices: Sequence[Device],
        mechanism: Mechanism[Any, State, Reference, Command],
        controller: Controller[Reference, State, Command],
        states: StateMachine,
        max_missed: int = 5,
        truth: Callable[[], tuple[float, ...]] = tuple,
    ) -> None:
        self.clock = clock
        self.period = period
        self.buses = buses
        self.devices = devices
        self.mechanism = mechanism
        self.controller = controller
        self.states = states
        self.max_missed = max_missed
        self.truth = truth
        self.t: float | None = None
        """Time since the first cycle, s; None before it."""

    def run(
        self,
        motion: Motion[Reference],
        *,
        recorder: Recorder,
        events: Callable[[float, str, str, dict[str, Any]], None],
        stop: StopRequests,
        timings: Timings = Timings(),  # noqa: B008 - immutable
        progress: Callable[[Progress], None] | None = None,
        progress_every: float = 0.1,
    ) -> Outcome:
        """Energise, approach, follow the motion, release; make safe on every way out.

        Parameters
        ----------
        motion : Motion
            What to follow.
        recorder : Recorder
            Receives one row per cycle: `RUN_COLUMNS`, the mechanism's, `TIMING_COLUMNS`,
            the truth.
        events : callable
            ``events(t, kind, message, data)``.
        stop : StopRequests
            Read once a cycle.
        timings : Timings
            Durations of energising, approach and release.
        progress : callable, optional
            Called about every `progress_every` seconds of rig time.

        Returns
        -------
        Outcome
            Never raises for what happens on the rig; a `BaseException` that is no `Exception`
            makes safe and passes on.
        """
        run = Phases(
            self.mechanism, self.controller, self.states, motion, timings, period=self.period
        )
        self.states.move(RigState.RUNNING)
        stop.in_loop = True
        fault: Exception | None = None
        try:
            self._cycle(run, recorder, events, stop, progress, progress_every)
        except Exception as error:
            fault = error
        finally:
            self.make_safe(None if fault is None else self._recording(run, recorder))
            stop.in_loop = False
        if fault is None:
            self.states.move(RigState.STOPPING) if run.phase is not Phase.STOP else None
            self.states.move(RigState.IDLE)
        else:
            self.states.latch_fault(fault)
        for name, hits in self.mechanism.limit_hits().items():
            if hits:
                message = f"{name} was limited in {hits} cycles of the run"
                events(run.t, "limit", message, {"hits": hits})
        return Outcome(run.cycles, run.missed, stop.count, fault)

    def make_safe(self, recording: StopRecording | None = None) -> None:
        """Give every device its safe setpoint; repeat it for `SAFE_CYCLES`, or a recorded stop."""
        for _ in range(max(SAFE_CYCLES, recording.cycles if recording else 0)):
            for device in self.devices:
                device.make_safe()
            now = self.clock.now()
            for bus in self.buses:
                with contextlib.suppress(Exception):  # one dead bus must not keep another from it
                    bus.receive(now)
                try:
                    bus.transmit(now)
                except Exception:
                    bus.make_safe()
            if recording:
                recording(now)
            self.clock.sleep_until(now + self.period)

    def _recording(self, run: "Phases[Any, Any, Any]", recorder: Recorder) -> StopRecording:
        return StopRecording(
            self.mechanism, recorder.write, self.truth, TIMING_COLUMNS, self.period, run.start,
            phase=float(Phase.STOP), reference_time=run.reference_time, last=run.t,
        )  # fmt: skip

    def _cycle(
        self,
        run: "Phases[State, Reference, Command]",
        recorder: Recorder,
        events: Callable[[float, str, str, dict[str, Any]], None],
        stop: StopRequests,
        progress: Callable[[Progress], None] | None,
        progress_every: float,
    ) -> None:
        # Bound once: the cycle is the hot path.
        clock_now, sleep_until = self.clock.now, self.clock.sleep_until
        buses, devices, mechanism = self.buses, self.devices, self.mechanism
        period = self.period
        show_every = max(1, round(progress_every / period))

        limits = _LimitWatch(events)
        start = run.start = clock_now()
        tick = 0
        late_in_a_row = 0
        record_time = 0.0
        while True:
            now = clock_now()
            t = now - start
            run.t = self.t = t
            began = perf_counter()
            for bus in buses:
                bus.receive(now)
            received = perf_counter()
            state = mechanism.read(now)
            fault: Exception | None = None
            try:
                for device in devices:
                    device.check(now)
                for bus in buses:
                    bus.check(now)
                mechanism.check(state, now)
            except Exception as error:
                fault = _with_cause(error, state, mechanism, devices, now)
            read = perf_counter()

            if fault is None:
                reference, command = run.step(t, state, stop.count)
                applied = mechanism.limit(command)
            else:  # this cycle is recorded like every other, with what is about to be sent
                reference = mechanism.reference_of(state)
                command = applied = mechanism.released_command()
            mechanism.write(applied)
            controlled = perf_counter()
            if fault is None:
                for bus in buses:
                    bus.transmit(now)
            sent = perf_counter()

            row = (
                float(run.phase),
                run.reference_time,
                *mechanism.row(state, reference, command, applied),
                t - tick * period,
                period - (sent - began) - record_time,
                received - began,
                read - received,
                controlled - read,
                sent - controlled,
                record_time,
                *self.truth(),
            )
            recorder.write(tick, t, row)
            record_time = perf_counter() - sent
            run.cycles += 1
            if fault is not None:
                raise fault
            if run.cycles % show_every == 0:
                limits.watch(t, mechanism.limit_hits())
                if progress is not None:
                    margin = mechanism.worst_margin(state, applied, now)
                    progress(
                        Progress(run.phase, run.reference_time, run.duration, margin, run.missed)
                    )
            if run.finished:
                return

            tick += 1
            late_by = clock_now() - (start + tick * period)
            if late_by > 0.0:
                skipped = math.ceil(late_by / period)
                tick += skipped
                run.missed += skipped
                late_in_a_row += skipped
                events(t, "overrun", f"{skipped} ticks missed", {"late": late_by})
                if late_in_a_row > self.max_missed:
                    raise LoopStalled(
                        f"{late_in_a_row} ticks of {period * 1e3:g} ms missed in a row, "
                        f"at most {self.max_missed} are allowed"
                    )
            else:
                late_in_a_row = 0
            sleep_until(start + tick * period)


def _with_cause(
    error: Exception,
    state: State,
    mechanism: Mechanism[Any, State, Reference, Command],
    devices: Sequence[Device],
    now: float,
) -> Exception:
    """Return the error with its cause as the mechanism knows it, or as the devices doubt."""
    found = mechanism.explain(error, state)
    if found is error and isinstance(error, LimitExceeded):
        doubts = [device.doubt(now) for device in devices]
        suspicion = "; ".join(doubt for doubt in doubts if doubt)
        return error.suspecting(suspicion) if suspicion else error
    return found


class _LimitWatch:
    """Tells when a limit begins to clip the command; every cycle would be too much."""

    def __init__(self, events: Callable[[float, str, str, dict[str, Any]], None]) -> None:
        self._events = events
        self._seen: dict[str, int] = {}
        self._clipping: set[str] = set()

    def watch(self, t: float, hits: dict[str, int]) -> None:
        """Compare the counters with those of the last call."""
        for name, count in hits.items():
            if count == self._seen.get(name, 0):
                self._clipping.discard(name)
                continue
            if name not in self._clipping:
                self._clipping.add(name)
                self._events(t, "limit", f"{name} is limited", {"hits": count})
            self._seen[name] = count
