"""Let the `shared_time` pass: ``time_keeper.py FOLDER``.

It has to be the least of all programs on the only processor, so that it runs when every other one
waits, and only then: all of them have a real-time policy, and it is idle.
"""

import os
import sys
import time
from math import inf
from pathlib import Path

from shared_time import SharedTime, pipe_of

_LOOK = 1e-3  # while nobody waits for an instant, s of the kernel's time


def keep(shared: SharedTime) -> None:
    """Go from one instant that somebody waits for to the next, for ever."""
    values, pipes = shared.values, {}
    while True:
        seats = values[1:].tolist()
        first = min(seats)
        if first == inf:
            time.sleep(_LOOK)
            continue
        values[0] = max(values[0], first)
        number = 1 + seats.index(first)
        if number not in pipes:
            pipes[number] = os.open(pipe_of(shared.folder, number), os.O_RDWR | os.O_NONBLOCK)
        values[number] = inf
        os.write(pipes[number], b"!")  # whoever is woken runs before this goes on


if __name__ == "__main__":
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    keep(SharedTime(Path(sys.argv[1])))
