"""Have a Python program live in the `shared_time` that ``SHARED_TIME`` names.

Only what waits and what tells monotonic time is replaced, in every program alike.

Python imports a module of this name by itself where it is on the path.
"""

import os
import select
import time
from pathlib import Path

from shared_time import SharedTime


def _take_part(shared: SharedTime) -> None:
    kernel_sleep, kernel_select = time.sleep, select.select

    def sleep(seconds):
        if seconds > 0.0:
            shared.sleep(seconds)
        else:
            kernel_sleep(seconds)

    def wait(read, write, error, timeout=None):
        if not timeout or write or error:
            return kernel_select(read, write, error, timeout)
        return shared.wait(timeout, read), [], []

    time.monotonic = time.perf_counter = shared.now
    time.sleep, select.select = sleep, wait


if os.environ.get("SHARED_TIME"):
    _take_part(SharedTime(Path(os.environ["SHARED_TIME"])))
