"""How late a loop is woken: what is counted, and what is said of it."""

import subprocess

import numpy as np
import pytest

from rig.doctor import wakeups
from rig.doctor.look import Fitness, Look
from rig.doctor.wakeups import Wakeups, abuse, judge, measure_wakeups

PERIOD = 1e-3


class LateClock:
    """A clock that wakes so much late, one wake-up after the other."""

    def __init__(self, late):
        self.time, self.late = 0.0, iter(late)

    def now(self):
        return self.time

    def sleep_until(self, t):
        self.time = max(self.time, t) + next(self.late)


@pytest.mark.parametrize("seed", range(3))
def test_what_a_clock_is_late_by_is_counted(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    late = rng.exponential(20e-6, 4000)
    late[rng.integers(4000)] = 2.5 * PERIOD
    monkeypatch.setattr(wakeups, "MonotonicClock", lambda spin: LateClock(late))
    told = []
    found = measure_wakeups(1.0 / PERIOD, 4.0, 0, tell=told.append)
    assert (found.waited, found.missed) == (4000, 1)
    assert found.worst == pytest.approx(2.5 * PERIOD)
    assert found.p50 == pytest.approx(np.quantile(late, 0.5), rel=0.01)
    assert found.p999 == pytest.approx(np.quantile(late, 0.999), rel=0.01)
    assert told == pytest.approx([1.0, 2.0, 3.0, 4.0])


@pytest.mark.parametrize(
    ("p99", "p999", "missed", "verdict"),
    [
        (50e-6, 0.1 * PERIOD, 0, Fitness.OK),
        (50e-6, 0.11 * PERIOD, 0, Fitness.POOR),
        (50e-6, 60e-6, 1, Fitness.POOR),
        (PERIOD, 2 * PERIOD, 9, Fitness.POOR),
        (1.01 * PERIOD, 2 * PERIOD, 99, Fitness.NO),
    ],
)
def test_wakeups_are_judged_by_the_period(p99, p999, missed, verdict):
    found = judge(Wakeups(PERIOD, 10_000, 1e-5, p99, p999, 3e-3, missed), "as it is")
    assert found.verdict is verdict
    assert f"{missed} of 10000 missed" in found.found
    assert bool(found.mend) is (verdict is not Fitness.OK)


def test_what_is_poor_has_its_bound():
    told = [
        judge(Wakeups(PERIOD, 10_000, 1e-5, p99, 2e-4, 3e-3, 1), "as it is").mend
        for p99 in (1e-4, 2e-3)
    ]
    assert told[0].startswith("ok is p99.9 within 100 us and none missed: ")
    assert told[1].startswith("p99 has to be within the period, 1000 us: ")


FIFO = "SCHED_FIFO at priority 80"
CLOCK = "clock of the processors"


@pytest.mark.parametrize(
    ("poor", "kernel", "begins"),
    [
        ((), "Linux 6.1, without PREEMPT_RT", "`apt install linux-image-rt-amd64` (PREEMPT_RT), "),
        ((), "Linux 6.1, PREEMPT_RT", "loop.cpu on a processor"),
        ((FIFO,), "Linux 6.1, PREEMPT_RT", f"what is poor above ({FIFO}); then loop.cpu"),
        ((FIFO, CLOCK), "Linux 6.1, PREEMPT_RT", f"what is poor above ({FIFO}, {CLOCK}); then "),
    ],
)
def test_nothing_is_mended_that_is_well(poor, kernel, begins):
    computer = [Look("kernel", kernel, Fitness.OK)]
    for what in (FIFO, CLOCK):
        is_poor = what in poor
        computer.append(Look(what, "", Fitness.POOR if is_poor else Fitness.OK, "x" * is_poor))
    found = judge(Wakeups(PERIOD, 10_000, 1e-5, 1e-4, 2e-4, 3e-3, 1), "as it is", computer)
    _, _, mend = found.mend.partition(": ")
    assert mend.startswith(begins)
    assert "ulimit" not in mend and "cpupower" not in mend


def test_a_load_ends_with_its_measurement(monkeypatch):
    started = []
    begin = subprocess.Popen
    monkeypatch.setattr(
        subprocess, "Popen", lambda *a, **k: started.append(begin(*a, **k)) or started[-1]
    )
    with abuse() as what:
        assert len(started) >= 3
        assert all(process.poll() is None for process in started)
        found = measure_wakeups(200.0, 0.2, 0)
    assert "fills memory" in what
    assert all(process.poll() is not None for process in started)
    assert found.waited == 40
    assert 0.0 <= found.p50 <= found.p99 <= found.worst
