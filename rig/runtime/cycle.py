"""One cycle of the loop: sense, decide, act, note; what each step takes is noted with it."""

from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any, Generic, Protocol

from rig.hal import Column, CyclicBus, Device, LimitExceeded, Mechanism, StaleReading
from rig.hal.mechanism import Command, Reference, State
from rig.runtime.phases import Phases

RUN_COLUMNS = (
    Column("phase", "", "0 approach, 1 run, 2 stop"),
    Column("clock", "s", "of the rig, at which the state was read"),
    Column("fault", "", "0 none, 1 seen in this cycle, 2 being made safe after one"),
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


class Recorder(Protocol):
    """The log of a run, a row for each cycle."""

    def write(self, cycle: int, t: float, row: Sequence[float]) -> None:
        """Append one cycle; it is with the operating system when this returns."""


def log_values_of(devices: Sequence[Device]) -> Callable[[], tuple[float, ...]]:
    """Return what tells the values of the devices' own columns, in their order."""
    tellers = [device.log_values for device in devices if device.log_columns]
    return lambda: tuple([value for teller in tellers for value in teller()])


class Cycle(Generic[State, Reference, Command]):
    """The steps of a cycle, in this order.

    Parameters
    ----------
    buses, devices : sequence
        Everything that is exchanged and checked.
    mechanism : Mechanism
        State, limits and log columns.
    run : Phases
        Which phase it is, and what is asked for in it.
    recorder : Recorder
        Receives one row per cycle: `RUN_COLUMNS`, the mechanism's, those of the devices,
        `TIMING_COLUMNS`, the truth.
    truth : callable
        In simulation: the plant's true values.
    period : float
        s.

    Attributes
    ----------
    fault : Exception or None
        What was seen in this cycle; such a cycle is recorded like every other, and sends nothing.
    """

    def __init__(
        self,
        buses: Sequence[CyclicBus],
        devices: Sequence[Device],
        mechanism: Mechanism[Any, State, Reference, Command],
        run: Phases[State, Reference, Command],
        recorder: Recorder,
        truth: Callable[[], tuple[float, ...]],
        period: float,
    ) -> None:
        self.fault: Exception | None = None
        self._buses = buses
        self._devices = devices
        self._mechanism = mechanism
        self._run = run
        self._measured = log_values_of(devices)
        self._record = recorder.write
        self._truth = truth
        self._period = period
        self._record_time = 0.0
        self._clock: float  # when the state was read, s

    def sense(self, now: float, lost: float, stall: Exception | None) -> State:
        """Drain the buses, assemble one frozen state, and check everything.

        Parameters
        ----------
        now : float
            s.
        lost : float
            Time that the program itself lost before this cycle, s. A reading is not too old for
            its sake: nobody could have asked for a newer one.
        stall : Exception or None
            The program lost too much of it: what is read is recorded, and not judged.

        Raises
        ------
        StaleReading
            There is no state to go on with.
        """
        self._began = perf_counter()
        for bus in self._buses:
            bus.receive(now)
        self._received = perf_counter()
        mechanism = self._mechanism
        self._clock = now
        try:
            state = mechanism.read(now)
        except StaleReading:
            if not lost:
                raise
            self._clock = now - lost
            state = mechanism.read(self._clock)
        self.fault = stall
        if stall is None:
            self._check(state, now, lost)
        self._read = perf_counter()
        return state

    def _check(self, state: State, now: float, lost: float) -> None:
        mechanism = self._mechanism
        try:
            for device in self._devices:
                device.check(now)
            for bus in self._buses:
                bus.check(now)
            mechanism.check(state, now)
        except StaleReading as error:
            if lost:
                self._check(state, now - lost, 0.0)
            else:
                self.fault = _with_cause(error, state, mechanism, self._devices, now)
        except Exception as error:
            self.fault = _with_cause(error, state, mechanism, self._devices, now)

    def decide(self, t: float, state: State, stops: int) -> tuple[Reference, Command, Command]:
        """Return the reference, what the controller wants, and what the limits leave of it."""
        mechanism = self._mechanism
        if self.fault is None:
            run = self._run
            try:
                run.reference, run.command = reference, command = run.step(t, state, stops)
            except LimitExceeded as error:  # what does not follow may have a cause that shows
                raise mechanism.explain(error, state) from error
            return reference, command, mechanism.limit(command)
        command = mechanism.released_command()  # what is about to be sent
        return mechanism.reference_of(state), command, command

    def act(self, now: float, applied: Command) -> None:
        """Hand the applied command to the devices, and send it."""
        self._mechanism.write(applied)
        self._controlled = perf_counter()
        if self.fault is None:
            for bus in self._buses:
                bus.transmit(now)
        self._sent = perf_counter()

    def busiest(self) -> str:
        """Return the step that took most of this cycle's work."""
        steps = {
            "receiving": self._received - self._began,
            "reading": self._read - self._received,
            "control": self._controlled - self._read,
            "sending": self._sent - self._controlled,
            "recording": self._record_time,
        }
        return max(steps, key=steps.__getitem__)

    def note(
        self,
        tick: int,
        t: float,
        state: State,
        reference: Reference,
        command: Command,
        applied: Command,
    ) -> None:
        """Record the cycle, with what its steps took."""
        run, began, sent = self._run, self._began, self._sent
        row = (
            float(run.phase),
            self._clock,
            0.0 if self.fault is None else 1.0,
            run.reference_time,
            *self._mechanism.row(state, reference, command, applied),
            *self._measured(),
            t - tick * self._period,
            self._period - (sent - began) - self._record_time,
            self._received - began,
            self._read - self._received,
            self._controlled - self._read,
            sent - self._controlled,
            self._record_time,
            *self._truth(),
        )
        self._record(tick, t, row)
        self._record_time = perf_counter() - sent
        run.cycles += 1


def _with_cause(
    error: Exception,
    state: State,
    mechanism: Mechanism[Any, State, Reference, Command],
    devices: Sequence[Device],
    now: float,
) -> Exception:
    """Return the error with its cause as the mechanism knows it, or as the devices doubt."""
    try:
        found = mechanism.explain(error, state)
    except Exception as failed:  # whatever fails in looking for a cause must not take its place
        error.add_note(f"its cause could not be looked for: {failed!r}")
        found = error
    if found is error and isinstance(error, LimitExceeded):
        doubts = [device.doubt(now) for device in devices]
        suspicion = "; ".join(doubt for doubt in doubts if doubt)
        return error.suspecting(suspicion) if suspicion else error
    return found
