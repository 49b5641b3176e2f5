"""Signals that end a command which moves nothing, taken for Ctrl-C."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rig.runtime.stop import ENDING


@contextmanager
def all_as_ctrl_c() -> Iterator[None]:
    """Take whatever ends a program for Ctrl-C: nothing may leave processes or files behind.

    What is ignored from the beginning goes on being ignored, as `nohup` wants it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are not ours
        return
    heard = [number for number in ENDING if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, signal.default_int_handler) for number in heard}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
