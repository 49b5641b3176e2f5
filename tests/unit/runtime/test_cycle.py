"""The steps of a cycle: what each does, and the times that are noted with it."""

import contextlib
import inspect
from types import SimpleNamespace

import pytest
from loop_fakes import (
    PERIOD,
    Bench,
    FakeBus,
    FakeDevice,
    FakeMechanism,
    FakeMotion,
    FakeRecorder,
)

from rig.hal import DeviceFault, LimitExceeded, LoopStalled, SafetyError, StaleReading
from rig.runtime import cycle as module
from rig.runtime.cycle import Cycle
from rig.runtime.loop import SAFE_CYCLES, Loop
from rig.runtime.phases import Phase
from rig.runtime.stop import StopRequests
from rig.runtime.stop_recording import StopRecording

STEPS = ("receiving", "reading", "control", "sending", "recording")


class Parts:
    """A cycle with a stopwatch that a test winds."""

    def __init__(self, monkeypatch, times=()):
        self.bus, self.device = FakeBus(), FakeDevice()
        self.mechanism, self.recorder = FakeMechanism(), FakeRecorder()
        self.run = SimpleNamespace(
            phase=Phase.RUN, reference_time=2.5, cycles=7, step=lambda *_: (1.0, 2.0)
        )
        times = iter(times)
        monkeypatch.setattr(module, "perf_counter", lambda: next(times, 0.0))
        self.cycle = Cycle(
            [self.bus], [self.device], self.mechanism, self.run, self.recorder,
            lambda: (99.0,), PERIOD,
        )  # fmt: skip

    def whole(self, tick, t):
        state = self.cycle.sense(t, 0.0, None)
        reference, command, applied = self.cycle.decide(t, state, 0)
        self.cycle.act(t, applied)
        self.cycle.note(tick, t, state, reference, command, applied)


def test_a_cycle_notes_when_it_began_and_what_its_steps_took(monkeypatch):
    first = (100.0, 100.5, 101.5, 103.5, 107.5, 115.5)  # 0.5, 1, 2, 4 and, to record it, 8
    second = (200.0, 201.0, 201.5, 209.5, 211.5, 220.0)
    parts = Parts(monkeypatch, (*first, *second))
    parts.whole(3, 3.25 * PERIOD)
    parts.whole(5, 5.0 * PERIOD)
    (tick, t, row), (_, _, after) = parts.recorder.rows
    assert (tick, t) == (3, 3.25 * PERIOD)
    assert row[:8] == (float(Phase.RUN), 3.25 * PERIOD, 0.0, 2.5, 7.0, 1.0, 2.0, 2.0)
    assert row[8:] == pytest.approx((0.25 * PERIOD, PERIOD - 7.5, 0.5, 1.0, 2.0, 4.0, 0.0, 99.0))
    assert after[8:] == pytest.approx((0.0, PERIOD - 19.5, 1.0, 0.5, 8.0, 2.0, 8.0, 99.0))
    assert parts.run.cycles == 9


@pytest.mark.parametrize("slowest", range(5))
def test_the_step_that_took_most_of_a_cycle_is_named(monkeypatch, slowest):
    times = [1000.0]
    for k in range(5):
        times.append(times[-1] + (1.0 if k != slowest else 3.0))
    parts = Parts(monkeypatch, times)
    parts.whole(0, 0.0)
    assert parts.cycle.busiest() == STEPS[slowest]


def test_nothing_is_wrong_before_the_first_cycle(monkeypatch):
    assert Parts(monkeypatch).cycle.fault is None


def test_a_state_is_asked_for_again_only_if_the_program_itself_lost_time(monkeypatch):
    parts, asked = Parts(monkeypatch), []
    error = StaleReading("encoder", 0.5, 0.03)

    def read(now):
        asked.append(now)
        raise error

    parts.mechanism.read = read
    for lost in (0.0, 0.25):
        with pytest.raises(StaleReading):
            parts.cycle.sense(1.0, lost, None)
    assert asked == [1.0, 1.0, 0.75]


def test_what_is_read_after_a_pause_that_was_too_long_is_not_judged(monkeypatch):
    parts, stall = Parts(monkeypatch), LoopStalled("the program was paused")
    parts.device.fault_at = 0.0
    assert parts.cycle.sense(1.0, 0.9, stall) == 7.0
    assert parts.cycle.fault is stall
    parts.cycle.sense(1.0, 0.0, None)
    assert isinstance(parts.cycle.fault, DeviceFault)


def test_a_cycle_that_saw_a_fault_sends_nothing(monkeypatch):
    parts = Parts(monkeypatch)
    parts.device.fault_at = 2.0
    for now, transmitted in ((1.0, 1), (2.0, 1)):
        state = parts.cycle.sense(now, 0.0, None)
        reference, command, applied = parts.cycle.decide(now, state, 0)
        parts.cycle.act(now, applied)
        parts.cycle.note(0, now, state, reference, command, applied)
        assert parts.bus.calls.count("transmit") == transmitted
    assert command == applied == 0.0
    assert [row[1:3] for _, _, row in parts.recorder.rows] == [(1.0, 0.0), (2.0, 1.0)]


def test_what_does_not_follow_is_told_with_its_cause(monkeypatch):
    parts = Parts(monkeypatch)
    fault, cause = LimitExceeded("x", 2.0, -1.0, 1.0, "m"), SafetyError("a chamber leaks")

    def step(*_):
        raise fault

    parts.run.step = step
    told = []
    parts.mechanism.explain = lambda error, state: told.append((error, state)) or cause
    state = parts.cycle.sense(1.0, 0.0, None)
    with pytest.raises(SafetyError) as caught:
        parts.cycle.decide(1.0, state, 0)
    assert (caught.value, told) == (cause, [(fault, state)])


def test_a_row_has_the_time_at_which_its_state_was_read(monkeypatch):
    parts = Parts(monkeypatch)

    def read(now):
        if now > 0.75:
            raise StaleReading("encoder", 0.5, 0.03)
        return 7.0

    parts.mechanism.read = read
    assert parts.cycle.sense(1.0, 0.25, None) == 7.0
    parts.cycle.act(1.0, 2.0)
    parts.cycle.note(0, 1.0, 7.0, 1.0, 2.0, 2.0)
    assert parts.recorder.rows[0][2][1] == 0.75


def test_a_device_without_columns_is_not_asked_for_values(monkeypatch):
    class Silent(FakeDevice):
        def log_values(self):
            raise AssertionError("it has no columns")

    assert module.log_values_of([Silent()])() == ()


# The loop around it ------------------------------------------------------------------------------


def test_what_a_loop_does_unless_told_otherwise():
    defaults = {
        name: one.default
        for made in (Loop, Loop.run)
        for name, one in inspect.signature(made).parameters.items()
    }
    assert (defaults["max_missed"], defaults["safe_within"]) == (5, 1.0)
    assert defaults["progress_every"] == 0.1
    assert SAFE_CYCLES == 5


def test_times_count_from_the_first_cycle_and_a_stop_is_only_a_request_meanwhile():
    bench, stop, inside = Bench(), StopRequests(), []
    bench.clock.time = 64.0
    bench.recorder.busy = lambda: inside.append(stop.in_loop)
    outcome = bench.run(stop)
    assert [round(t / PERIOD, 6) for _, t, _ in bench.recorder.rows] == list(range(outcome.cycles))
    assert all(inside) and not stop.in_loop
    assert outcome.cycles == len(inside) and outcome.missed == 0
    assert "rate was limited" not in {event[2][:16] for event in bench.events}


def test_a_stop_that_comes_while_the_rig_is_made_safe_does_not_interrupt_it():
    bench, stop, inside = Bench(), StopRequests(), []
    plain = bench.device.make_safe
    bench.device.make_safe = lambda: (inside.append(stop.in_loop), plain())
    bench.run(stop)
    assert inside == [True] * SAFE_CYCLES


def test_each_cycle_hears_the_requests_that_came_before_it():
    bench, stop, heard = Bench(), StopRequests(), []

    def busy():
        heard.append((stop.heard, stop.in_cycles))
        stop.count += len(heard) == 4

    bench.recorder.busy = busy
    bench.run(stop)
    assert heard[:4] == [(0, True)] * 4 and set(heard[4:]) == {(1, True)}
    assert not stop.in_cycles


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_nothing_of_a_cycle_that_was_torn_is_left_when_the_rig_is_made_safe(error):
    bench, stop, inside = Bench(), StopRequests(), []
    plain = bench.device.make_safe
    bench.device.make_safe = lambda: (inside.append(stop.in_cycles), plain())

    def update(*_):
        raise error

    bench.controller.update = update
    with contextlib.suppress(KeyboardInterrupt):
        bench.run(stop)
    assert len(inside) >= SAFE_CYCLES and not any(inside)
    assert not stop.in_loop


def test_buses_are_drained_while_the_rig_is_made_safe():
    bench = Bench()
    outcome = bench.run()
    assert bench.bus.calls[outcome.cycles * 3 :] == ["receive", "transmit"] * SAFE_CYCLES


def test_a_loop_has_neither_time_nor_phases_before_its_first_cycle():
    bench = Bench()
    loop = Loop(
        clock=bench.clock, period=PERIOD, buses=[], devices=[], mechanism=bench.mechanism,
        controller=bench.controller, states=bench.states,
    )  # fmt: skip
    assert loop.t is None
    assert loop.phases is None


def test_progress_is_told_every_cycle_if_that_is_asked_for():
    for every, share in ((PERIOD, 1), (0.5 * PERIOD, 1), (0.1 * PERIOD, 1), (3 * PERIOD, 3)):
        bench, told = Bench(), []
        bench.progress_every = every
        outcome = bench.run(progress=told.append)
        assert len(told) == outcome.cycles // share


def test_only_a_fault_is_followed_by_a_recorded_stop_and_only_for_its_time():
    bench = Bench()
    bench.mechanism.stopping_time = 3 * PERIOD
    cycles = bench.run().cycles
    assert len(bench.recorder.rows) == cycles

    bench = Bench()
    bench.mechanism.stopping_time = 3 * PERIOD
    bench.device.fault_at = 0.1
    bench.device.unsafe = lambda now: "it still moves" if bench.device.safe < 30 else ""
    outcome = bench.run()
    assert bench.device.safe == 30
    assert len(bench.recorder.rows) == outcome.cycles + 2  # the first one is the cycle of the fault


# The recorded stop -------------------------------------------------------------------------------


def stop_recording(mechanism, rows, last=3 * PERIOD):
    return StopRecording(
        mechanism, lambda *row: rows.append(row), tuple, tuple, (), PERIOD, 64.0,
        phase=2.0, reference_time=1.0, last=last,
    )  # fmt: skip


def test_a_stop_is_recorded_once_a_cycle_from_the_one_after_the_fault():
    mechanism, rows = FakeMechanism(), []
    mechanism.stopping_time = 4 * PERIOD
    recording = stop_recording(mechanism, rows)
    for k in (3.0, 4.0, 4.1, 5.0):
        recording(64.0 + k * PERIOD)
    assert [cycle for cycle, _, _ in rows] == [4, 5]
    assert [t for _, t, _ in rows] == pytest.approx([4 * PERIOD, 5 * PERIOD])
    assert [row[3] for _, _, row in rows] == pytest.approx([1.0 + PERIOD, 1.0 + 2 * PERIOD])
    assert [row[:3] for _, _, row in rows] == [(2.0, 64.0 + k * PERIOD, 2.0) for k in (4.0, 5.0)]


def test_a_disk_that_is_slow_does_not_draw_a_stop_out():
    mechanism, rows = FakeMechanism(), []
    mechanism.stopping_time = 0.25
    recording = stop_recording(mechanism, rows, last=0.25)
    for t in (1.5, 1.5 + PERIOD, 2.0):  # it lasts until 0.5 s, and a second more is waited
        recording(64.0 + t)
    assert [t for _, t, _ in rows] == [1.5]


def test_a_stop_whose_state_nobody_could_read_is_not_recorded():
    mechanism, rows = FakeMechanism(), []
    mechanism.stopping_time = 4 * PERIOD
    mechanism.read = lambda now: 1 / 0
    mechanism.row = lambda *values: (7.0,)
    stop_recording(mechanism, rows)(64.0 + 4 * PERIOD)
    assert rows == []


def test_what_a_motion_wants_written_is_an_event_of_its_cycle(monkeypatch):
    monkeypatch.setattr(FakeMotion, "watches", True, raising=False)
    monkeypatch.setattr(FakeMotion, "see", lambda *_: (("mark", "seen"),), raising=False)
    bench = Bench()
    bench.run()
    marks = [(round(t / PERIOD), message) for t, kind, message, _ in bench.events if kind == "mark"]
    assert marks == [(k, "seen") for k in range(10, 10 + len(marks))] and marks
