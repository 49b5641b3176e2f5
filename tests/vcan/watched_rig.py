"""`rig` with one thing more: what `rig simulate` simulates is written down, as it truly was.

``python watched_rig.py simulate …`` writes times, ``t`` (of `time.monotonic`, s), and ``rows`` of
the plant's truth to the file that ``WATCHED_TRUTH`` names when it ends. The program is as it is.
"""

import atexit
import os
import time
from array import array

import numpy as np

SAMPLE = 1e-3
"""Between two looks at the truth, s."""
_ROOM = 3_000_000
"""Numbers for which there is memory from the start: a loop in real time gets no more on its way."""


def watch(path):
    """Have every emulated rig of this process looked at, and what was seen written at its end."""
    from drivers.sim.emulated_rig import EmulatedRig

    passes = EmulatedRig.pass_until
    kept, used, due, width = array("d", bytes(8 * _ROOM)), 0, 0.0, 1

    def pass_until(world, t):
        nonlocal used, due, width
        passes(world, t)
        if world.time < due:
            return
        due = world.time + SAMPLE
        began = used
        for value in (time.monotonic(), *world.plant.truth()):
            kept[used] = value
            used += 1
        width = used - began

    def save():
        rows = np.array(kept[:used]).reshape(-1, width)
        np.savez(path, t=rows[:, 0], rows=rows[:, 1:])

    EmulatedRig.pass_until = pass_until
    atexit.register(save)


if __name__ == "__main__":
    watch(os.environ["WATCHED_TRUTH"])
    from rig.cli import main

    main()
