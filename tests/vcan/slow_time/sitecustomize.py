"""Let time pass more slowly for a Python program: ``SLOW_TIME=4`` makes a second last four.

User-mode Linux has one processor and takes a hundred times longer for a system call than the
kernel outside. Two programs in real time there would show how slow it is, and nothing else; with
this, both believe that the machine is so many times faster. Only what waits and what tells
monotonic time is changed, for both alike, and so is every process that they start.

Python imports a module of this name by itself where it is on the path.
"""

import os
import select
import time

_FACTOR = float(os.environ.get("SLOW_TIME", "1"))


def _slow_down(factor: float) -> None:
    monotonic, perf_counter = time.monotonic, time.perf_counter
    sleep, wait = time.sleep, select.select

    def slow_select(read, write, error, timeout=None):
        return wait(read, write, error, None if timeout is None else timeout * factor)

    time.monotonic = lambda: monotonic() / factor
    time.perf_counter = lambda: perf_counter() / factor
    time.sleep = lambda seconds: sleep(seconds * factor)
    select.select = slow_select


if _FACTOR != 1.0:
    _slow_down(_FACTOR)
