"""Copies of this process, which need not import anew what it has."""

import multiprocessing
import os
import threading


def may_copy() -> bool:
    """Return whether this process can be copied, and a copy has a processor of its own."""
    is_alone = threading.active_count() == 1 and not multiprocessing.current_process().daemon
    return is_alone and len(os.sched_getaffinity(0)) > 1
