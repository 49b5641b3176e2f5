"""How late the loop wakes up, beside cyclictest: same rate, priority and processor, in turn."""

import os
import re
import shutil
import subprocess
from statistics import median

import pytest

from rig.hal import MonotonicClock
from rig.runtime.realtime import real_time

PERIOD = 1e-3
PRIORITY = 80
SECONDS = 2
ROUNDS = 5
SPIN = 200e-6
BOUND = 1.25
BOUND_SPINNING = 0.2
LONGEST = 20_000  # of cyclictest's histogram, µs

pytestmark = pytest.mark.benchmark


def test_wakeup(table):
    if shutil.which("cyclictest") is None:
        pytest.skip("cyclictest is not installed (Debian: rt-tests)")
    if not may_be_real_time():
        pytest.skip("SCHED_FIFO is not permitted here")
    cpu = max(os.sched_getaffinity(0))
    ways = {
        "cyclictest": lambda: cyclictest(cpu),
        "MonotonicClock": lambda: lateness(MonotonicClock(), cpu),
        "MonotonicClock, spinning 200 µs": lambda: lateness(MonotonicClock(SPIN), cpu),
    }
    rounds = {name: [] for name in ways}
    for _ in range(ROUNDS):
        for name, measure in ways.items():
            rounds[name].append(sorted(measure()))
    p99 = {name: median(percentile(late, 0.99) for late in rounds[name]) for name in ways}
    for name, samples in rounds.items():
        table(
            what=name,
            p50_us=1e6 * median(percentile(late, 0.5) for late in samples),
            p99_us=1e6 * p99[name],
            worst_us=1e6 * max(late[-1] for late in samples),
            ratio=p99[name] / p99["cyclictest"],
            p99s=" ".join(f"{1e6 * percentile(late, 0.99):.1f}" for late in samples),
        )
    plain, spinning = (p99[name] / p99["cyclictest"] for name in list(ways)[1:])
    assert plain <= BOUND
    assert spinning <= BOUND_SPINNING


def percentile(ordered, share):
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)]


def may_be_real_time():
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError:
        return False
    os.sched_setscheduler(0, *before)
    return True


def lateness(clock, cpu):
    """Return how late each cycle starts, s, as the loop waits for it."""
    late = []
    now, sleep_until = clock.now, clock.sleep_until
    with real_time(PRIORITY, cpu) as refused:
        assert not refused, refused
        start = now() + PERIOD
        for k in range(int(SECONDS / PERIOD)):
            deadline = start + k * PERIOD
            sleep_until(deadline)
            late.append(now() - deadline)
    return late


def cyclictest(cpu):
    """Return how late each of cyclictest's cycles started, s."""
    done = subprocess.run(
        ["cyclictest", "-q", "-m", "-i", f"{PERIOD * 1e6:.0f}", "-p", str(PRIORITY),
         "-a", str(cpu), "-l", str(int(SECONDS / PERIOD)), "-h", str(LONGEST)],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    bins = re.findall(r"^(\d+)\s+(\d+)\s*$", done.stdout, re.MULTILINE)
    late = [int(us) * 1e-6 for us, count in bins for _ in range(int(count))]
    assert len(late) > 0.9 * SECONDS / PERIOD, done.stdout[-500:]
    return late
