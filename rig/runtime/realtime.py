"""Real-time scheduling of the loop where the system permits it, a plain sentence where not."""

import ctypes
import gc
import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager

_MCL_CURRENT = 1
_MCL_FUTURE = 2
_PR_SET_TIMERSLACK = 29
_DEFAULT_TIMER_SLACK = 50_000
"""Linux's default timer slack, ns: every sleep may end that much late."""
_POWER_SAVING = "/dev/cpu_dma_latency"
"""While it is open, processors take no longer to wake from idle than was written to it, µs."""


@contextmanager
def real_time(priority: int, cpu: int | None = None) -> Iterator[list[str]]:
    """Run the enclosed loop with as few reasons to be late as the system permits.

    Takes SCHED_FIFO at `priority`, locks memory, keeps the processors out of idle states that
    they are slow to leave, sets the timer slack to 1 ns, pins to `cpu` and stops the garbage
    collector, and undoes all of it at the end.

    Parameters
    ----------
    priority : int
        SCHED_FIFO priority, 1 … 99; 0 leaves the default scheduler.
    cpu : int, optional
        The processor to stay on.

    Yields
    ------
    list of str
        A sentence for each measure that was refused: what it costs and what would permit it.
        Empty when all were taken.
    """
    refused: list[str] = []
    libc = ctypes.CDLL(None, use_errno=True)
    affinity = os.sched_getaffinity(0)
    policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    locked = False
    awake = -1
    try:
        if cpu is not None:
            try:
                os.sched_setaffinity(0, {cpu})
            except OSError as error:
                refused.append(f"The loop is not pinned to processor {cpu}: {error.strerror}.")
        if priority:
            try:
                os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
            except OSError:
                refused.append(
                    "The loop runs without SCHED_FIFO: beside other work, single cycles may come "
                    "several milliseconds late. `ulimit -r 99` (rtprio in "
                    "/etc/security/limits.conf) or CAP_SYS_NICE permits it."
                )
            locked = libc.mlockall(_MCL_CURRENT | _MCL_FUTURE) == 0
            if not locked:
                refused.append(
                    "Memory is not locked: a page fault may delay a cycle. `ulimit -l unlimited` "
                    "(memlock in /etc/security/limits.conf) permits it."
                )
            try:
                awake = os.open(_POWER_SAVING, os.O_WRONLY | os.O_CLOEXEC)
                os.write(awake, struct.pack("i", 0))
            except OSError as error:
                refused.append(
                    "Processors may save power between cycles, and each cycle then comes some "
                    f"10 µs later: {_POWER_SAVING}: {error.strerror}. Write permission on it "
                    "(a udev rule) permits it."
                )
        libc.prctl(_PR_SET_TIMERSLACK, 1)
        if priority:  # a tenth of a second, which a simulated clock has no use for
            gc.collect()
        gc.freeze()
        gc.disable()
        yield refused
    finally:
        gc.enable()
        gc.unfreeze()
        libc.prctl(_PR_SET_TIMERSLACK, _DEFAULT_TIMER_SLACK)
        if awake >= 0:
            os.close(awake)
        if locked:
            libc.munlockall()
        if os.sched_getscheduler(0) != policy:
            os.sched_setscheduler(0, policy, parameters)
        if os.sched_getaffinity(0) != affinity:
            os.sched_setaffinity(0, affinity)
