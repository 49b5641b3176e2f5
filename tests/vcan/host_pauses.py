"""Write down the longest pause of this host, ms, until killed: ``python host_pauses.py FILE``.

A loop that does nothing wakes every millisecond, before all other work (SCHED_FIFO): what it is
late by is the host's, of which a virtual machine sees nothing else. A rig that may miss five
ticks of 1 ms stands still on such a host, and no test of it says anything about the program.
"""

import sys
import time
from pathlib import Path

from rig.runtime.realtime import real_time

PERIOD = 1e-3


def main() -> None:
    """Watch for ever."""
    file, worst = Path(sys.argv[1]), 0.0
    with real_time(90):
        due = time.monotonic()
        while True:
            due += PERIOD
            time.sleep(max(due - time.monotonic(), 0.0))
            late = time.monotonic() - due
            if late > worst:
                worst = late
                file.write_text(f"{1e3 * worst:.1f}\n", encoding="utf-8")
            if late > PERIOD:
                due = time.monotonic()


if __name__ == "__main__":
    main()
