"""Let the `shared_time` pass: ``time_keeper.py FOLDER``.

It has to be the least of all programs on the only processor, so that it runs when every other one
waits, and only then: all of them have a real-time policy, and it is idle. That is not enough by
itself: since Linux 6.12 a program that could not run for a second gets a twentieth of the next. So
it also asks the kernel whether anybody else could run now.

While there is a file `PACED`, it does not pass faster than the kernel's, in which programs of other
people live.
"""

import os
import sys
import time
from math import inf
from pathlib import Path

from shared_time import PACED, SharedTime, pipe_of

_LOOK = 1e-3  # while nobody waits for an instant, s of the kernel's time
_BEHIND = 0.01  # no more is made up for, s: what was slow for long is not followed by haste
_LOAD = "/proc/loadavg"  # three averages, then how many could run now, of how many


def keep(shared: SharedTime) -> None:
    """Go from one instant that somebody waits for to the next, for ever."""
    values, pipes = shared.values, {}
    load = os.open(_LOAD, os.O_RDONLY)
    paced, came = shared.folder / PACED, -inf  # the kernel's time to which this one has come
    while True:
        if int(os.pread(load, 64, 0).split()[3].partition(b"/")[0]) > 1:
            os.sched_yield()
            continue
        seats = values[1:].tolist()
        first = min(seats)
        if first == inf:
            time.sleep(_LOOK)
            continue
        passed = max(0.0, first - values[0])
        if paced.exists():
            now = time.monotonic()
            came = max(came, now - _BEHIND)
            ahead = came + passed - now
            if ahead > _LOOK:
                time.sleep(ahead)
                continue
            came += passed
        values[0] = max(values[0], first)
        number = 1 + seats.index(first)
        if number not in pipes:
            pipes[number] = os.open(pipe_of(shared.folder, number), os.O_RDWR | os.O_NONBLOCK)
        values[number] = inf
        os.write(pipes[number], b"!")  # whoever is woken runs before this goes on


if __name__ == "__main__":
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    keep(SharedTime(Path(sys.argv[1])))
