"""The ways through a cycle that a good run never takes, and what is recorded of them."""

import random

import pytest
from loop_fakes import PERIOD, Bench, FakeDevice

from rig.hal import Column, DeviceFault, LoopStalled, StaleReading
from rig.runtime.loop import SAFE_CYCLES
from rig.runtime.phases import Phase
from rig.runtime.states import RigState

CYCLES = range(2, 20)
"""All of them are before the end of the bench's run."""


def stale():
    return StaleReading("encoder", 0.5, 0.03)


@pytest.mark.parametrize("cycle", random.Random(1).sample(CYCLES, 4))
def test_a_state_that_cannot_be_read_ends_the_run_and_nothing_more_is_written(cycle):
    bench = Bench()
    error = stale()

    def read(now):
        if len(bench.recorder.rows) >= cycle:
            raise error
        return 7.0

    bench.mechanism.read = read
    assert bench.run().fault is error
    assert len(bench.recorder.rows) == len(bench.mechanism.written) == cycle
    assert bench.device.safe >= SAFE_CYCLES
    assert bench.states.state is RigState.FAULT


def test_a_bus_that_cannot_be_drained_ends_the_run():
    bench = Bench()
    bench.bus.fail.add("receive")
    assert str(bench.run().fault) == "can0 is down"
    assert bench.mechanism.written == []
    assert bench.device.safe >= SAFE_CYCLES


@pytest.mark.parametrize("place", ["read", "check"])
@pytest.mark.parametrize(("age", "faulty"), [(2.4, False), (2.6, True)])
def test_a_reading_is_not_too_old_for_what_the_program_itself_lost(place, age, faulty):
    """One tick and a half is lost; a reading may be one period old."""
    bench = Bench(max_missed=5)
    bench.clock.oversleep = (0.05, 1.5 * PERIOD)
    taken = 0.05 + 1.5 * PERIOD - age * PERIOD

    def judge(now):
        if bench.recorder.rows[-1:] and len(bench.recorder.rows) == 5 and now - taken > PERIOD:
            raise StaleReading("encoder", now - taken, PERIOD)

    def read(now):
        judge(now)
        return 7.0

    if place == "read":
        bench.mechanism.read = read
    else:
        bench.mechanism.check = lambda state, now: judge(now)
    fault = bench.run().fault
    assert isinstance(fault, StaleReading) is faulty
    assert (fault is None) is not faulty


def test_one_tick_missed_is_no_pause_that_a_device_may_be_excused_for():
    """Its watchdog is longer than two periods: what it then says is its own."""
    bench = Bench(max_missed=5)
    broken = DeviceFault("drive", "it broke")

    def busy():
        if len(bench.recorder.rows) == 3:
            bench.clock.time += 1.5 * PERIOD

    def check(now):
        if len(bench.recorder.rows) == 5:
            raise broken

    bench.recorder.busy, bench.device.check = busy, check
    outcome = bench.run()
    assert outcome.fault is broken
    assert outcome.missed == 1


def test_a_release_that_takes_no_time_is_the_cycle_after_the_motion():
    bench = Bench()
    bench.run(release=0.0)
    phases = [row[0] for _, _, row in bench.recorder.rows]
    assert phases.count(float(Phase.STOP)) == 1
    assert bench.mechanism.written[-2:] == [50.0, 0.0]


def test_progress_is_told_with_the_phase_and_the_worst_margin():
    bench, told = Bench(), []
    bench.run(progress=told.append)
    assert [entry.phase for entry in told] == sorted(entry.phase for entry in told)
    assert {entry.phase for entry in told} == set(Phase)
    assert {(entry.duration, entry.margin.fraction, entry.missed) for entry in told} == {
        (0.1, 1.0, 0)
    }
    assert len(told) == len(bench.recorder.rows) // 2


def test_progress_is_told_with_the_clock_of_the_log_beside_that_of_the_reference():
    bench, told = Bench(), []
    bench.run(progress=told.append)
    logged = [(t, row[3]) for _, t, row in bench.recorder.rows]
    assert {(entry.elapsed, entry.t) for entry in told} <= set(logged)
    assert [entry.elapsed - entry.t for entry in told] != [0.0] * len(told)


class Telling(FakeDevice):
    """Has values of its own for the log."""

    log_columns = (Column("one", "V", ""), Column("two", "V", ""))

    def log_values(self):
        return (11.0, 12.0)


def test_what_devices_tell_of_themselves_stands_before_the_timings():
    bench = Bench(truth=lambda: (99.0,))
    bench.devices = [bench.device, Telling()]
    bench.run()
    for _, _, row in bench.recorder.rows:
        assert row[8:10] == (11.0, 12.0)
        assert len(row) == 4 + 4 + 2 + 7 + 1
        assert row[2] == 0.0
        assert row[-1] == 99.0


# The stop after a fault, recorded ---------------------------------------------------------------


def braked(cycle, read=None, write=None):
    """Return a bench whose mechanism takes 8.5 periods to stop, after a fault at a cycle."""
    bench = Bench()
    bench.devices = [bench.device, Telling()]
    bench.mechanism.stopping_time = 8.5 * PERIOD
    bench.device.fault_at = (cycle - 0.5) * PERIOD
    plain = bench.mechanism.read
    bench.mechanism.read = lambda now: read(now) if read and bench.device.safe else plain(now)
    bench.recorder.busy = lambda: write() if write and bench.device.safe else None
    assert isinstance(bench.run().fault, DeviceFault)
    assert bench.device.safe == 9  # longer than the safe setpoints are repeated at least
    return bench, [row for row in bench.recorder.rows if row[0] > cycle]


@pytest.mark.parametrize("cycle", random.Random(2).sample(CYCLES, 4))
def test_the_stop_is_recorded_cycle_by_cycle_with_what_is_sent(cycle):
    states = iter(range(100, 200))
    bench, stop = braked(cycle, read=lambda now: float(next(states)))
    faulty = bench.recorder.rows[-len(stop) - 1]
    assert [k for k, _, _ in stop] == list(range(cycle + 1, cycle + 9))
    for n, (k, t, row) in enumerate(stop):
        assert t == pytest.approx(k * PERIOD)
        assert row[0] == float(Phase.STOP)
        assert row[1] - faulty[2][1] == pytest.approx((n + 1) * PERIOD)
        assert (faulty[2][2], row[2]) == (1.0, 2.0)
        assert row[3] - faulty[2][3] == pytest.approx((n + 1) * PERIOD)
        assert row[4:8] == (100.0 + n, 100.0 + n, 0.0, 0.0)
        assert row[8:] == (11.0, 12.0) + (0.0,) * 7


def test_a_device_that_falls_silent_in_the_stop_leaves_its_last_reading():
    values = iter((20.0, 30.0, 40.0))

    def read(now):
        for value in values:
            return value
        raise stale()

    _, stop = braked(6, read=read)
    assert [row[4] for _, _, row in stop] == [20.0, 30.0] + [40.0] * 6


def test_a_log_that_fails_does_not_keep_the_rig_from_its_stop():
    def write():
        raise OSError("disk full")

    braked(6, write=write)


def test_a_pause_and_a_state_that_cannot_be_read_after_it_are_the_pauses_fault():
    bench = Bench(max_missed=5)
    bench.clock.oversleep = (0.05, 20.0 * PERIOD)

    def read(now):
        if len(bench.recorder.rows) == 5:
            raise stale()
        return 7.0

    bench.mechanism.read = read
    fault = bench.run().fault
    assert isinstance(fault, LoopStalled)
    assert isinstance(fault.__cause__, StaleReading)
