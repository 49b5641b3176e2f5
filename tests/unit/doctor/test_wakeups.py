"""How late a loop is woken: what is counted, and what is said of it."""

import subprocess

import numpy as np
import pytest

from rig.doctor import wakeups
from rig.doctor.look import Fitness
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
