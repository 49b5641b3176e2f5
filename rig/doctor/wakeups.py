"""How late this computer wakes the loop, idle and under load.

It sleeps as the loop does (`MonotonicClock` under `real_time`), and does nothing else: what it is
late by is the computer's.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Final, NamedTuple

import numpy as np

from rig.doctor.computer import KERNEL, REAL_TIME
from rig.doctor.look import Fitness, Look
from rig.hal.clock import SPIN, MonotonicClock
from rig.runtime.realtime import real_time

_GOOD: Final = 0.1
"""A loop whose wake-ups are late by less than this share of the period is not disturbed."""

_LOADS: Final = (
    "while True: pass",
    "import os,sys\nwith open(sys.argv[1],'wb') as f:\n"
    " while True: f.seek(0); f.write(os.urandom(1<<22)); f.flush(); os.fsync(f.fileno())",
    "while True: bytearray(1<<26)",
)
"""A processor, the disk and the memory, each kept busy."""


class Wakeups(NamedTuple):
    """Lateness of the wake-ups of a loop that does nothing.

    Parameters
    ----------
    period : float
        s.
    waited : int
        How many were waited for.
    p50, p99, p999, worst : float
        s.
    missed : int
        How many came later than the next one was due.
    """

    period: float
    waited: int
    p50: float
    p99: float
    p999: float
    worst: float
    missed: int


def measure_wakeups(
    rate: float,
    seconds: float,
    priority: int,
    cpu: int | None = None,
    *,
    spin: bool = False,
    tell: Callable[[float], None] = lambda done: None,
) -> Wakeups:
    """Return how late wake-ups come.

    Parameters
    ----------
    rate : float
        Of the loop, Hz.
    seconds : float
        For how long.
    priority, cpu : int
        As the profile's ``loop`` says.
    spin : bool
        Likewise.
    tell : callable
        Called each second with how many are over.
    """
    period, count = 1.0 / rate, max(round(rate * seconds), 1)
    late = np.empty(count)
    clock = MonotonicClock(SPIN if spin else 0.0)
    each = max(round(rate), 1)
    with real_time(priority, cpu):
        due = clock.now()
        for k in range(count):
            due += period
            clock.sleep_until(due)
            late[k] = now = clock.now() - due
            if now > period:
                due += period * (now // period)  # as the loop does: what is missed is missed
            if k % each == each - 1:
                tell((k + 1) * period)
    p50, p99, p999 = (float(q) for q in np.quantile(late, (0.5, 0.99, 0.999)))
    return Wakeups(
        period, count, p50, p99, p999, float(late.max()), int(np.count_nonzero(late > period))
    )


@contextmanager
def abuse() -> Iterator[str]:
    """Keep processors, disk and memory busy meanwhile, and yield what is done in words."""
    processors = os.cpu_count() or 1
    with ExitStack() as stack:
        file = stack.enter_context(tempfile.NamedTemporaryFile())
        for load in (_LOADS[0],) * processors + _LOADS[1:]:
            process = subprocess.Popen([sys.executable, "-c", load, file.name])
            stack.callback(process.wait)
            stack.callback(process.kill)
        yield f"{processors} busy processes, one that writes to the disk, one that fills memory"


def judge(wakeups: Wakeups, under: str, computer: Sequence[Look] = ()) -> Look:
    """Return what wake-ups under a load mean for a loop.

    Parameters
    ----------
    wakeups : Wakeups
        As measured.
    under : str
        The load, in words.
    computer : sequence of Look
        What was found of the computer. Its own lines say how what is poor there is mended.
    """
    period = wakeups.period
    what = f"wake-ups at {1.0 / period:g} Hz, {under}"
    found = (
        f"p50 {_us(wakeups.p50)}, p99 {_us(wakeups.p99)}, p99.9 {_us(wakeups.p999)}, "
        f"worst {_us(wakeups.worst)} late, {wakeups.missed} of {wakeups.waited} missed"
    )
    if wakeups.p999 <= _GOOD * period and not wakeups.missed:
        return Look(what, found, Fitness.OK)
    mend = _mend(computer)
    if wakeups.p99 <= period:
        why = f"ok is p99.9 within {_us(_GOOD * period)} and none missed: {mend}"
        return Look(what, found, Fitness.POOR, why)
    why = f"p99 has to be within the period, {_us(period)}: {mend}; a lower loop.rate"
    return Look(what, found, Fitness.NO, why)


def _mend(computer: Sequence[Look]) -> str:
    """Return what may help beyond what is told of the computer already."""
    poor = [one.what for one in computer if one.verdict is Fitness.POOR and one.mend]
    is_real_time = any(one.what == KERNEL and REAL_TIME in one.found for one in computer)
    first = [f"what is poor above ({', '.join(poor)})"] if poor else []
    kernel = [] if is_real_time else ["`apt install linux-image-rt-amd64` (PREEMPT_RT)"]
    processor = "loop.cpu on a processor that `isolcpus=` keeps free"
    return "; then ".join([*first, ", and ".join([*kernel, processor])])


def _us(seconds: float) -> str:
    return f"{seconds * 1e6:.0f} us"
