"""Signals that end a command which moves nothing, taken for Ctrl-C."""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from time import monotonic
from types import FrameType

from rig.runtime.stop import ENDING

_LOOK = 0.005
"""Between two looks whether an interrupt that has to wait may come now, s."""
_PATIENCE = 2.0
"""An import that takes longer is interrupted, s."""


_LAST_PATIENCE = 5.0
"""An interrupted process that has not ended by then is ended, s."""


class _Interrupt(KeyboardInterrupt):
    """Ctrl-C as this module raises it: if it gets lost, it is raised again.

    Parameters
    ----------
    number : int
        The signal that it is for.
    """

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


class _Waiting:
    """The signal whose interrupt has to wait; None: there is none."""

    number: int | None = None
    since = 0.0


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Interrupt, but for an import: what is written in C may make another error of it there.

    A second one does not wait.
    """
    if _Waiting.number is None and _imports(frame):
        _wait_with(number)
        return
    _Waiting.number = None
    raise _Interrupt(number)


def _wait_with(number: int) -> None:
    _Waiting.number, _Waiting.since = number, monotonic()
    signal.signal(signal.SIGALRM, _look_again)
    signal.setitimer(signal.ITIMER_REAL, _LOOK)


def _look_again(_: int, frame: FrameType | None) -> None:
    """Interrupt now if it does no harm; whoever hears signals by now gets this one."""
    number = _Waiting.number
    if number is None:
        return
    if signal.getsignal(number) is not _interrupt:
        _Waiting.number = None
        signal.raise_signal(number)
    elif _imports(frame) and monotonic() - _Waiting.since < _PATIENCE:
        signal.setitimer(signal.ITIMER_REAL, _LOOK)
    else:
        _Waiting.number = None
        raise _Interrupt(number)


def _imports(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _lost(
    hook: Callable[["sys.UnraisableHookArgs"], object], unraisable: "sys.UnraisableHookArgs"
) -> None:
    """Raise again what was raised where Python drops it, as in a destructor."""
    if isinstance(unraisable.exc_value, _Interrupt):
        _wait_with(unraisable.exc_value.number)
    else:
        hook(unraisable)


def _forget() -> None:
    """In a copy of this process: its signals are as they are where nobody takes them for Ctrl-C."""
    _Waiting.number = None
    for number in ENDING:
        if signal.getsignal(number) is _interrupt:
            is_ctrl_c = number == signal.SIGINT
            signal.signal(number, signal.default_int_handler if is_ctrl_c else signal.SIG_DFL)


os.register_at_fork(after_in_child=_forget)


@contextmanager
def all_as_ctrl_c() -> Iterator[None]:
    """Take whatever ends a program for Ctrl-C: nothing may leave processes or files behind.

    What is ignored from the beginning goes on being ignored, as `nohup` wants it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are not ours
        return
    heard = [number for number in ENDING if signal.getsignal(number) is not signal.SIG_IGN]
    hook, sys.unraisablehook = sys.unraisablehook, partial(_lost, sys.unraisablehook)
    before = {number: signal.signal(number, _interrupt) for number in heard}
    try:
        yield
        if _Waiting.number is not None:  # in vain, as it were
            number, _Waiting.number = _Waiting.number, None
            raise _Interrupt(number)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        sys.unraisablehook = hook


def end_by_signals(*, is_interrupted: bool) -> None:
    """Let signals end this process without a word: it has done what it was begun for.

    Parameters
    ----------
    is_interrupted : bool
        One has ended it: no other changes how, while Python puts away what it has; one comes of
        itself if that takes too long.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    for number in ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, signal.SIG_IGN if is_interrupted else signal.SIG_DFL)
    if is_interrupted:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, _LAST_PATIENCE)
