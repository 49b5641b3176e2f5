"""Ticks that each rig misses beside a C loop that does nothing, under whatever load there is.

    python tests/benchmarks/missed_ticks.py [--minutes 10] [--rigs cylinder joint arm legs]

Loop and C program run at the same time, on the same processor, with the same period and priority:
what keeps both from running is the host's. The rig is fed with a recorded run (`fed_rig`), over and
over: receive, read, check, control, send, record. The frames are handed to it in the same thread,
behind each cycle. A tick that begins a period late or later counts as missed, on both sides.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

try:
    import pytest
except ModuleNotFoundError:
    sys.exit("this needs pytest and what comes with it: pip install -e '.[test]'")
from asked_minutes import minutes
from fed_rig import Feeder, SerialEnd, feed, record_run, rig_on_ends, run, take_terminals
from test_cycle_cost_of_rigs import PLANS, plan_of

from rig.hal import MonotonicClock
from rig.runtime.realtime import real_time

PRIORITY = 80
PROGRAM = r"""
#define _GNU_SOURCE
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <time.h>

int main(int count, char **words)
{
    long period = atol(words[1]), ticks = atol(words[2]), missed = 0, worst = 0;
    struct sched_param its = {.sched_priority = atoi(words[3])};
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    CPU_SET(atoi(words[4]), &cpus);
    if (sched_setaffinity(0, sizeof cpus, &cpus) || sched_setscheduler(0, SCHED_FIFO, &its)
        || mlockall(MCL_CURRENT | MCL_FUTURE))
        return 1;
    struct timespec at, now;
    clock_gettime(CLOCK_MONOTONIC, &at);
    for (long k = 0; k < ticks; k++) {
        at.tv_nsec += period;
        while (at.tv_nsec >= 1000000000L) {
            at.tv_nsec -= 1000000000L;
            at.tv_sec++;
        }
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL);
        clock_gettime(CLOCK_MONOTONIC, &now);
        long late = (now.tv_sec - at.tv_sec) * 1000000000L + now.tv_nsec - at.tv_nsec;
        missed += late >= period;
        worst = late > worst ? late : worst;
    }
    printf("%ld %ld\n", missed, worst);
    return 0;
}
"""


class RealFeeder(Feeder):
    """Feeds a rig whose virtual time passes as real time does; notes how late each tick is."""

    def __init__(self, ends, came):
        super().__init__(ends, came)
        self.late, self.work = [], []
        self._real = MonotonicClock()
        self._began = None
        self._woke = 0.0

    def advance(self, t):
        now = self._real.now()
        if self._began is None:
            self._began = now - t
        self.work.append(now - self._woke)
        came = next(self._came, {})
        for name, end in self._ends.items():
            end.drain()
            content = came.get(name, ())
            if isinstance(end, SerialEnd):
                end.put(content)  # the kernel passes it on while the loop sleeps
            else:
                feed(end, content)
        self._real.sleep_until(self._began + t)
        self._woke = self._real.now()
        self.late.append(self._woke - self._began - t)


def once(patch, name, recorded, path, program, cpu):
    """Run a rig once beside the C loop; return its feeder, and what the C loop says."""
    plan = plan_of(name)
    period = plan.profile.loop.period
    with rig_on_ends(patch, plan.profile) as (rig, ends):
        take_terminals(rig, ends)
        world, rig.clock.world = rig.clock.world, RealFeeder(ends, recorded.came)
        feeder = rig.clock.world
        words = [program, f"{period * 1e9:.0f}", str(len(recorded.came)), str(PRIORITY), str(cpu)]
        with real_time(PRIORITY, cpu) as refused:
            assert not refused, refused
            beside = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
            run(rig, plan, path, rig.clock)
        rig.clock.world = world
        for end in ends.values():
            if isinstance(end, SerialEnd):
                end.shutdown()
    told, _ = beside.communicate()
    path.unlink()
    missed, worst = map(int, told.split())
    return feeder, missed, 1e-9 * worst


def measure(name, minutes, folder, program, cpu):
    """Print a row about one rig."""
    late, work, theirs, worst = [], [], 0, 0.0
    with pytest.MonkeyPatch.context() as patch:
        recorded = record_run(patch, plan_of(name), folder / f"{name}.mcap")
        period = plan_of(name).profile.loop.period
        while len(late) * period < 60.0 * minutes:
            feeder, missed, longest = once(patch, name, recorded, folder / "run.mcap", program, cpu)
            late += feeder.late
            work += feeder.work[1:]
            theirs += missed
            worst = max(worst, longest)
    late, work = np.array(late), np.array(work)
    ours = int(np.count_nonzero(late >= period))
    sys.stdout.write(
        f"| {name} | {len(late)} of {1e3 * period:g} ms | {ours} | {theirs} | "
        f"{1e3 * late.max():.2f} | {1e3 * worst:.2f} | {1e6 * np.median(work):.0f} | "
        f"{1e6 * np.quantile(work, 0.999):.0f} | {os.getloadavg()[1]:.1f} |\n"
    )
    sys.stdout.flush()


def main():
    """Measure each rig, and print a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--minutes", type=minutes, default=10.0)
    parser.add_argument("--cpu", type=int, default=max(os.sched_getaffinity(0)))
    parser.add_argument("--rigs", nargs="+", choices=PLANS, default=list(PLANS))
    asked = parser.parse_args()
    began = time.monotonic()
    sys.stdout.write(
        "| rig | ticks | missed | missed by C | latest, ms | C's latest, ms | "
        "a cycle, median, us | 99.9 % | load |\n|---|---|---|---|---|---|---|---|---|\n"
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        source, program = folder / "loop.c", folder / "loop"
        source.write_text(PROGRAM, encoding="utf-8")
        subprocess.run(["cc", "-O2", "-o", program, source], check=True)
        for rig in asked.rigs:
            measure(rig, asked.minutes, folder, program, asked.cpu)
    sys.stdout.write(f"it took {time.monotonic() - began:.0f} s\n")


if __name__ == "__main__":
    main()
