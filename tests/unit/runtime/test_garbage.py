"""Garbage of runs: a program of many of them does not grow by what each leaves behind."""

import subprocess
import sys

MANY_RUNS = """
import gc
from rig.runtime.realtime import real_time

class Knows:
    def __init__(self):
        self.knows = [self]  # as parts of a rig know each other

with real_time(0):
    pass
most, left = 0, max(5000, len(gc.get_objects()) // 8)
before = len(gc.get_objects())
for _ in range(40):
    rig = [Knows() for _ in range(left)]
    with real_time(0):
        assert not gc.isenabled()
    assert gc.isenabled() and not gc.get_freeze_count()
    del rig
    most = max(most, len(gc.get_objects()))
print((most - before) / left)
"""


def test_cycles_that_runs_leave_do_not_pile_up():
    """Told in rigs: in a process of its own, which has nothing of other tests to look through."""
    done = subprocess.run(
        [sys.executable, "-c", MANY_RUNS], capture_output=True, text=True, check=True
    )
    assert float(done.stdout) < 20.0
