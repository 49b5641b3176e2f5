"""The fixed-rate cycle that every rig runs on every backend.

One cycle: drain the buses, read one frozen state, check it, update the controller, limit,
write, record, and sleep to an absolute deadline (``start + k * period``). A cycle that comes
late skips ticks; it never bursts to catch up. Whatever goes wrong, every device is made safe,
and told so for several cycles, before anything else happens.
"""

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, NamedTuple

from rig.hal import Clock, CyclicBus, Device
from rig.hal.controller import Controller
from rig.hal.fits import shown
from rig.hal.mechanism import Command, Mechanism, Reference, State
from rig.hal.motion import Motion
from rig.hal.quantities import Margin
from rig.runtime.bus_watch import BusWatch
from rig.runtime.cycle import TIMING_COLUMNS, Cycle, Recorder, log_values_of
from rig.runtime.pace import Pace
from rig.runtime.phases import Events, Phase, Phases, Timings
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests
from rig.runtime.stop_recording import StopRecording

SAFE_CYCLES = 5
"""How many cycles the safe setpoints are repeated: one lost frame must not matter."""


class Progress(NamedTuple):
    """The state of a run, for a progress line.

    Parameters
    ----------
    phase : Phase
    elapsed : float
        Time since the run began, s: the clock of the log and of its events.
    t, duration : float
        Time of the reference, s, negative before its motion begins; and what it lasts.
    margin : Margin
    missed : int
        Ticks that were skipped.
    """

    phase: Phase
    elapsed: float
    t: float
    duration: float
    margin: Margin
    missed: int


class Outcome(NamedTuple):
    """The end of a run.

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
    unsafe : tuple of str
        What the devices' readings do not show to be safe, although it was told to be.
    """

    cycles: int
    missed: int
    stopped: int
    fault: Exception | None
    unsafe: tuple[str, ...] = ()


@dataclass(eq=False, kw_only=True)
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
    safe_within : float
        For how long at most the safe setpoints are repeated until the devices say that they are
        safe, s.
    truth : callable, optional
        In simulation: the plant's true values, appended to each row.
    """

    clock: Clock
    period: float
    buses: Sequence[CyclicBus]
    devices: Sequence[Device]
    mechanism: Mechanism[Any, State, Reference, Command]
    controller: Controller[Reference, State, Command]
    states: StateMachine
    max_missed: int = 5
    safe_within: float = 1.0
    truth: Callable[[], tuple[float, ...]] = tuple
    t: float | None = field(init=False, default=None)
    """Time since the first cycle, s; None before it."""
    start: float | None = field(init=False, default=None)
    """When the first cycle began by the clock, s; None before it."""
    phases: Phases[State, Reference, Command] | None = field(init=False, default=None)
    """The way of the run, also after it; None before it."""

    def run(
        self,
        motion: Motion[Reference],
        *,
        recorder: Recorder,
        events: Events,
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
            Receives one row per cycle: `RUN_COLUMNS`, the mechanism's, the devices',
            `TIMING_COLUMNS`, the truth.
        events : callable
            ``events(t, kind, message, data)``.
        stop : StopRequests
            Read once a cycle; what keeps a cycle from its end is interrupted by a further one.
        timings : Timings
            Durations of energising, approach, braking and release.
        progress : callable, optional
            Called about every `progress_every` seconds of rig time.

        Returns
        -------
        Outcome
            Never raises for what happens on the rig; a `BaseException` that is no `Exception`
            makes safe and passes on.
        """
        run = self.phases = Phases(
            self.mechanism, self.controller, self.states, motion, timings, period=self.period
        )
        self.states.move(RigState.RUNNING)
        stop.in_loop = True
        fault: Exception | None = None
        unsafe: tuple[str, ...] = ()
        try:
            try:
                stop.in_cycles = True
                self._cycles(run, recorder, events, stop, progress, progress_every)
            finally:
                stop.in_cycles = False
        except Exception as error:
            fault = error
        finally:
            unsafe = self.make_safe(
                None if fault is None else self._recording(run, recorder),
                self.mechanism.venting_time,
            )
            stop.in_loop = False
        if fault is None:
            self.states.move(RigState.IDLE)
        else:
            self.states.latch_fault(fault)
        for name, hits in self.mechanism.limit_hits().items():
            if hits:
                message = f"{name} was limited in {hits} cycles of the run"
                events(run.t, "limit", message, {"hits": hits})
        return Outcome(run.cycles, run.missed, stop.count, fault, unsafe)

    def make_safe(
        self, recording: StopRecording | None = None, waits: float = 0.0
    ) -> tuple[str, ...]:
        """Give every device its safe setpoint until they all say that they are safe.

        It is repeated for `SAFE_CYCLES`, a recorded stop and `waits` (s) at least, and
        `safe_within` at most.

        Returns
        -------
        tuple of str
            A sentence for each device that is not known to be safe in the end, and for what the
            mechanism has seen that a device hides.
        """
        recorded = recording.cycles if recording else SAFE_CYCLES
        waits = min(waits, self.safe_within)
        least = max(SAFE_CYCLES, recorded, math.ceil(waits / self.period))
        most = max(least, math.ceil(self.safe_within / self.period))
        unsafe: list[str] = []
        for cycle in range(1, most + 1):
            refused = self._send_safe()
            now = self.clock.now()
            doubt = _ask_whether_safe("the mechanism", self.mechanism.unsafe, now)
            if recording and cycle <= recorded:
                recording(now)
            self.clock.sleep_until(now + self.period)
            if cycle >= least:
                unsafe = [*refused, *filter(None, [*self._unsafe(), doubt])]
                if not unsafe:
                    break
        return tuple(unsafe)

    def _send_safe(self) -> list[str]:
        """Exchange the safe setpoints once; return who refuses them, which stops nobody else."""
        refused = []
        for device in self.devices:
            try:
                device.make_safe()
            except Exception as error:
                refused.append(f"{device.name}: it cannot be made safe: {error!r}")
        now = self.clock.now()
        for bus in self.buses:
            with contextlib.suppress(Exception):  # one dead bus must not keep another from it
                bus.receive(now)
            try:
                bus.transmit(now)
            except Exception:
                with contextlib.suppress(Exception):
                    bus.make_safe()
        return refused

    def _unsafe(self) -> list[str]:
        now = self.clock.now()
        return [_ask_whether_safe(device.name, device.unsafe, now) for device in self.devices]

    def _recording(self, run: "Phases[Any, Any, Any]", recorder: Recorder) -> StopRecording:
        return StopRecording(
            self.mechanism, recorder.write, log_values_of(self.devices), self.truth,
            TIMING_COLUMNS, self.period, run.start,
            phase=float(Phase.STOP), reference_time=run.reference_time, last=run.t,
        )  # fmt: skip

    def _cycles(
        self,
        run: "Phases[State, Reference, Command]",
        recorder: Recorder,
        events: Events,
        stop: StopRequests,
        progress: Callable[[Progress], None] | None,
        progress_every: float,
    ) -> None:
        clock_now, mechanism, period = self.clock.now, self.mechanism, self.period
        show_every = max(1, round(progress_every / period))
        limits, buses = _LimitWatch(events), BusWatch(self.buses, events)
        pace = Pace(run, period, self.max_missed, events)
        cycle = Cycle(self.buses, self.devices, mechanism, run, recorder, self.truth, period)
        start = run.start = self.start = clock_now()
        while True:
            now = clock_now()
            run.t = self.t = t = now - start
            pace.wake(t)
            try:
                state = cycle.sense(now, pace.lost, pace.stall)
            except Exception as error:
                raise (pace.stall or pace.blame(error)) from error
            stop.heard = stop.count
            reference, command, applied = cycle.decide(t, state, stop.heard)
            cycle.act(now, applied)
            run.hand_over(events)
            try:
                cycle.note(pace.tick, t, state, reference, command, applied)
            finally:
                if cycle.fault is not None:  # seen first: a log that fails does not hide it
                    raise pace.blame(cycle.fault)
            if run.cycles % show_every == 0:
                limits.watch(t, mechanism.limit_hits())
                buses.look(t)
                if progress is not None:
                    margin = mechanism.worst_margin(state, applied, now)
                    at = run.reference_time
                    progress(Progress(run.phase, t, at, run.duration, margin, run.missed))
            if run.finished:
                return
            due = pace.advance(t, clock_now() - start, cycle.busiest)
            self.clock.sleep_until(start + due)


def _ask_whether_safe(name: str, unsafe: Callable[[float], object], now: float) -> str:
    """Return why somebody is not known to be safe; whoever cannot say so is not, either."""
    try:
        said = unsafe(now)
    except Exception as error:
        return f"{name}: not known to be safe: {error!r}"
    return said if isinstance(said, str) else f"{name}: unsafe returned {shown(said)}"


class _LimitWatch:
    """Tells when a limit begins to clip the command; every cycle would be too much."""

    def __init__(self, events: Events) -> None:
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
