"""Copies of this process, which need not import anew what it has, and share out its work."""

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import Final, Generic, NamedTuple, Self, TypeVar

from rig.runtime.parent import end_with
from rig.runtime.stop import ENDING

Result = TypeVar("Result")

_PATIENCE: Final = 5.0
"""So long a copy may take to put away what it writes when it is told to end, s."""
_SOON: Final = 4.0
"""After this it ends with whatever it has not put away, s."""


class Lost(NamedTuple):
    """A task whose copy ended in the midst of it, though no other was at work.

    Parameters
    ----------
    code : int
        How the copy ended: its exit code, or a signal's number with a minus.
    """

    code: int

    def __str__(self) -> str:
        if self.code >= 0:
            return f"the process that drew it ended with exit code {self.code}"
        told = f"the process that drew it was ended by {signal.Signals(-self.code).name}"
        scarce = -self.code == signal.SIGKILL
        return f"{told}, most likely for lack of memory" if scarce else told


def may_copy() -> bool:
    """Return whether this process can be copied, and a copy has a processor of its own."""
    is_alone = threading.active_count() == 1 and not multiprocessing.current_process().daemon
    return is_alone and len(os.sched_getaffinity(0)) > 1


def end_when_told(parent: int) -> None:
    """Have this copy leave Ctrl-C to its parent, and end by itself when it is told to, or orphaned.

    It takes the files away that it is about to write. What is told before this comes after it, if
    the copy was begun by `begin`.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is for the process that waits
    for number in set(ENDING) - {signal.SIGINT}:
        signal.signal(number, _end)
    signal.signal(signal.SIGALRM, lambda *_: os._exit(0))
    sys.unraisablehook = _unraisable
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    end_with(parent, signal.SIGTERM)


def begin(process: BaseProcess) -> None:
    """Begin a copy that hears no signal until it calls `end_when_told`."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def ending_quietly() -> Iterator[None]:
    """End without a word whatever becomes of a copy that was told to end, as of a torn import."""
    try:
        yield
    except BaseException:
        if signal.getsignal(signal.SIGTERM) is _deaf:
            os._exit(0)
        raise


def _end(*_: object) -> None:
    """End in the orderly way, once; and soon, whoever takes that for an error of his own."""
    for number in ENDING:
        signal.signal(number, _deaf)  # to ignore one that has come already Python calls an error
    signal.setitimer(signal.ITIMER_REAL, _SOON)
    raise SystemExit


def _deaf(*_: object) -> None:
    """Leave a signal alone: the end has begun."""


def _unraisable(lost: "sys.UnraisableHookArgs") -> None:
    """End where Python would only say that it drops the end, as in a destructor."""
    if isinstance(lost.exc_value, SystemExit):
        os._exit(0)
    sys.__unraisablehook__(lost)


def share_out(
    work: Callable[[str], Result], tasks: Sequence[str], workers: int
) -> list[Result | Lost]:
    """Do tasks in copies of this process; return what comes of each, in their order.

    The copies are spoken to by pipes alone: a queue or a pool of `multiprocessing` takes semaphores
    from /dev/shm, which need not be writable. What a copy that is killed had begun is done again,
    alone, when the others have ended: what it lacked may be memory.

    Raises
    ------
    Exception
        As the work does.
    """
    done: dict[int, Result | Lost] = {}
    waiting = list(range(len(tasks)))[::-1]
    busy: dict[Connection, tuple[_Copy[Result], int]] = {}
    lost: list[int] = []
    with ExitStack() as stack:
        idle = _begin(stack, work, workers)
        while (idle and waiting) or busy:
            while idle and waiting:
                copy, number = idle.pop(), waiting.pop()
                copy.ask(tasks[number])
                busy[copy.line] = copy, number
            for line in wait(list(busy)):
                assert isinstance(line, Connection)
                copy, number = busy.pop(line)
                try:
                    done[number] = copy.answer()
                except EOFError:
                    lost.append(number)
                else:
                    idle.append(copy)
    for number in (*lost, *waiting[::-1]):
        done[number] = _do_alone(work, tasks[number])
    return [done[number] for number in range(len(tasks))]


class _Copy(Generic[Result]):
    """A copy of this process that does one task after the other.

    Raises
    ------
    OSError
        There is no room for one more process.
    """

    def __init__(self, work: Callable[[str], Result]) -> None:
        self.line, theirs = multiprocessing.Pipe()
        context = multiprocessing.get_context("fork")
        self._process = context.Process(target=_work, args=(work, theirs, self.line, os.getpid()))
        with theirs:  # else its end would never be seen
            begin(self._process)

    def ask(self, task: str) -> None:
        """Hand it a task; whether it is still there shows in its answer."""
        with contextlib.suppress(OSError):
            self.line.send(task)

    def answer(self) -> Result:
        """Return what came of the task, or raise that; EOFError: the copy has ended."""
        try:
            result, error, cause = self.line.recv()
        except OSError as gone:
            raise EOFError from gone
        if error is not None:
            raise error from cause
        told: Result = result
        return told

    def end(self) -> int:
        """End it; return its exit code, or the number of a signal with a minus."""
        self.line.close()
        self._process.join(0.0)
        self._process.terminate()
        self._process.join(_PATIENCE)
        self._process.kill()
        self._process.join()
        code = self._process.exitcode
        assert code is not None
        return code

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        self.end()


def _begin(stack: ExitStack, work: Callable[[str], Result], workers: int) -> list[_Copy[Result]]:
    """Return as many copies as there is room for, at most so many; a stack ends them."""
    copies: list[_Copy[Result]] = []
    with contextlib.suppress(OSError):
        while len(copies) < workers:
            copies.append(stack.enter_context(_Copy(work)))
    return copies


def _do_alone(work: Callable[[str], Result], task: str) -> Result | Lost:
    try:
        copy = _Copy(work)
    except OSError:
        return work(task)
    with copy:
        copy.ask(task)
        try:
            return copy.answer()
        except EOFError:
            return Lost(copy.end())


def _work(
    work: Callable[[str], object], line: Connection, not_ours: Connection, parent: int
) -> None:
    """Do tasks in this process until there is nobody to tell."""
    end_when_told(parent)
    not_ours.close()
    with ending_quietly(), contextlib.suppress(EOFError, OSError):
        while True:
            line.send(_outcome(work, line.recv()))


def _outcome(
    work: Callable[[str], object], task: str
) -> tuple[object, Exception | None, BaseException | None]:
    """Return what comes of a task, or the error and its cause, with which its asker has to deal."""
    try:
        return work(task), None, None
    except Exception as error:
        return None, error, error.__cause__
