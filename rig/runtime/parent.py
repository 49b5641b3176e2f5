"""The process that began this one, and what becomes of this one when that ends."""

import ctypes
import os
import signal
from typing import Final

_PR_SET_PDEATHSIG: Final = 1


def die_with_parent(number: int = signal.SIGKILL) -> None:
    """Have the kernel send this process a signal when the one that began it ends, however it does.

    Parameters
    ----------
    number : int
        The signal; one that is heard lets this process take its files away.
    """
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, number)


def end_with(parent: int, number: int) -> None:
    """Do as `die_with_parent`, and end at once if that parent has ended before."""
    die_with_parent(number)
    if os.getppid() != parent:
        os._exit(0)
