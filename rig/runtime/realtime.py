"""Real-time scheduling of the loop where the system permits it, a plain sentence where not."""

import ctypes
import gc
import os
import struct
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Final

_MCL_CURRENT = 1
_MCL_FUTURE = 2
_PR_SET_TIMERSLACK = 29
_PR_GET_TIMERSLACK = 30
_POWER_SAVING = "/dev/cpu_dma_latency"
"""While it is open, processors take no longer to wake from idle than was written to it, µs."""
_GROWN: Final = 1.5
"""So many times as many objects as were left the last time: garbage may be among them."""
_LIBC = ctypes.CDLL(None, use_errno=True)


def timer_slack() -> tuple[int, int]:
    """Return the timer slack of this thread, ns, and the least that the loop is given."""
    before = int(_LIBC.prctl(_PR_GET_TIMERSLACK))
    _LIBC.prctl(_PR_SET_TIMERSLACK, 1)
    least = int(_LIBC.prctl(_PR_GET_TIMERSLACK))
    _LIBC.prctl(_PR_SET_TIMERSLACK, before)
    return before, least


class _Heap:
    """All objects of this process, which a loop does not look through.

    Runs leave garbage in cycles. What was frozen counts as old afterwards, and the collector does
    not look for garbage because there is more of that. A program of many runs would only grow.
    """

    def __init__(self) -> None:
        self._kept = 0
        """Objects that were left when garbage was last looked for."""

    def freeze(self, *, look: bool) -> None:
        """Freeze what is there; look for garbage before if asked, or if half of it may be some."""
        gc.freeze()
        found = gc.get_freeze_count()
        if look or found > _GROWN * self._kept > 0:
            gc.unfreeze()
            gc.collect()
            gc.freeze()
            found = self._kept = gc.get_freeze_count()
        self._kept = self._kept or found


_HEAP: Final = _Heap()


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
    with ExitStack() as undo:
        # Undone last: a kernel that knows no slack under SCHED_FIFO would not hear of it before.
        undo.callback(_LIBC.prctl, _PR_SET_TIMERSLACK, int(_LIBC.prctl(_PR_GET_TIMERSLACK)))
        if cpu is not None:
            _pin(cpu, undo, refused)
        if priority:
            _take_fifo(priority, undo, refused)
            _lock_memory(undo, refused)
            _stay_awake(undo, refused)
        _LIBC.prctl(_PR_SET_TIMERSLACK, 1)
        _HEAP.freeze(look=priority > 0)  # a tenth of a second, which no simulated clock needs
        gc.disable()
        undo.callback(gc.unfreeze)
        undo.callback(gc.enable)
        yield refused


def _pin(cpu: int, undo: ExitStack, refused: list[str]) -> None:
    before = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {cpu})
    except OSError as error:
        refused.append(f"The loop is not pinned to processor {cpu}: {error.strerror}.")
    else:
        undo.callback(os.sched_setaffinity, 0, before)


def _take_fifo(priority: int, undo: ExitStack, refused: list[str]) -> None:
    policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        refused.append(
            "The loop runs without SCHED_FIFO: beside other work, single cycles may come "
            "several milliseconds late. `ulimit -r 99` (rtprio in "
            "/etc/security/limits.conf) or CAP_SYS_NICE permits it."
        )
    else:
        undo.callback(os.sched_setscheduler, 0, policy, parameters)


def _lock_memory(undo: ExitStack, refused: list[str]) -> None:
    if _LIBC.mlockall(_MCL_CURRENT | _MCL_FUTURE) == 0:
        undo.callback(_LIBC.munlockall)
        return
    refused.append(
        "Memory is not locked: a page fault may delay a cycle. `ulimit -l unlimited` "
        "(memlock in /etc/security/limits.conf) permits it."
    )


def _stay_awake(undo: ExitStack, refused: list[str]) -> None:
    try:
        awake = os.open(_POWER_SAVING, os.O_WRONLY | os.O_CLOEXEC)
        undo.callback(os.close, awake)
        os.write(awake, struct.pack("i", 0))
    except OSError as error:
        refused.append(
            "Processors may save power between cycles, and each cycle then comes some "
            f"10 µs later: {_POWER_SAVING}: {error.strerror}. Write permission on it "
            "(a udev rule) permits it."
        )
