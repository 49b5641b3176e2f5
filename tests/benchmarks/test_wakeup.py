"""How late the loop wakes up, beside cyclictest: same rate, priority and processor, in turn.

The machine is not quiet, and its neighbours come and go: so the windows are short, there are
hundreds of them, one of each way in turn, and neighbours in time are compared with each other. The
figure is the median of the windows' ratios, with the interval that holds it in 95 of 100
resamplings.
"""

import os
import re
import shutil
import subprocess

import numpy as np
import pytest
from intervals import ratio_of

from rig.hal import MonotonicClock
from rig.runtime.realtime import real_time

PERIOD = 1e-3
PRIORITY = 80
CYCLES = 150
"""Of a window."""
WINDOWS = 300
SPIN = 200e-6
WANTED, WANTED_SPINNING = 1.1, 0.1
BOUND, BOUND_SPINNING = 1.5, 0.25
"""What the lower end of the interval may not pass."""
LONGEST = 20_000  # of cyclictest's histogram, µs

pytestmark = pytest.mark.benchmark


def test_wakeup(table):
    if shutil.which("cyclictest") is None:
        pytest.skip("cyclictest is not installed (Debian: rt-tests)")
    if not may_be_real_time():
        pytest.skip("SCHED_FIFO is not permitted here")
    cpu = max(os.sched_getaffinity(0))
    plain, spinning = MonotonicClock(), MonotonicClock(SPIN)
    ways = {
        "cyclictest": lambda: cyclictest(cpu),
        "MonotonicClock": lambda: lateness(plain, cpu),
        "MonotonicClock, spinning 200 µs": lambda: lateness(spinning, cpu),
    }
    windows = {name: [] for name in ways}
    names = list(ways)
    for number in range(WINDOWS):
        for name in names[number % 3 :] + names[: number % 3]:
            windows[name].append(np.percentile(ways[name](), [50.0, 90.0, 99.0]))
    beside = np.array(windows["cyclictest"])
    found = {}
    for name, rows in windows.items():
        late = np.array(rows)
        for k, share in enumerate(("50", "90", "99")):
            ratio, low, high = ratio_of(late[:, k], beside[:, k])
            found[name, share] = low
            table(
                what=f"{name}, {share} %", us=1e6 * float(np.median(late[:, k])),
                over_cyclictest=ratio, low=low, high=high,
            )  # fmt: skip
    table(what="wanted", sleeping=WANTED, spinning=WANTED_SPINNING, windows=WINDOWS)
    for share in ("50", "99"):
        assert found["MonotonicClock", share] <= BOUND
        assert found["MonotonicClock, spinning 200 µs", share] <= BOUND_SPINNING


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
        for k in range(CYCLES):
            deadline = start + k * PERIOD
            sleep_until(deadline)
            late.append(now() - deadline)
    return late


def cyclictest(cpu):
    """Return how late each of cyclictest's cycles started, s."""
    done = subprocess.run(
        ["cyclictest", "-q", "-m", "-i", f"{PERIOD * 1e6:.0f}", "-p", str(PRIORITY),
         "-a", str(cpu), "-l", str(CYCLES), "-h", str(LONGEST)],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    bins = re.findall(r"^(\d+)\s+(\d+)\s*$", done.stdout, re.MULTILINE)
    late = [int(us) * 1e-6 for us, count in bins for _ in range(int(count))]
    assert len(late) > 0.9 * CYCLES, done.stdout[-500:]
    return late
