"""One time for several programs, which passes while none of them has anything to do.

User-mode Linux has one processor and takes ten to a hundred times longer for a system call than
the kernel outside: programs in real time would show how slow it is, or how busy its host, and
nothing else. In this time every computer is infinitely fast. It stands still while a program works,
and when all of them wait it goes on to the first instant that one of them waits for.

Who sees to that is the `time_keeper`, a program that runs only when no other can.
"""

import contextlib
import mmap
import os
import select
import threading
import time
from collections.abc import Iterable
from math import inf
from pathlib import Path
from typing import Any

MOST = 1023
"""So many threads can have waited, of all programs that ever took part."""
PACED = "paced"
"""A file beside the time: while it is there, programs take part that know nothing of this time."""
SHORTEST = 1e-6
"""A wait takes so long at least, s: a difference of two instants may round to nothing."""
LOOKS = 100
"""After so many looks at the time a program waits, by way of `SHORTEST`."""
_SIZE = 8 * (1 + MOST)
_select = select.select  # these modules' own may be replaced


class SharedTime:
    """The time, as every program that takes part sees it.

    Parameters
    ----------
    folder : Path
        Where `create_time` was; of this machine's memory.

    Attributes
    ----------
    values : memoryview of float
        The time, and until when each thread waits, s.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with (folder / "time").open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), _SIZE)
        self.values = memoryview(self._map).cast("d")
        self._own = threading.local()
        os.register_at_fork(after_in_child=self._forget_seat)
        self._looks = 0  # at the time, since somebody of this program waited

    def now(self) -> float:
        """Return the time, s; who does nothing but ask has it pass."""
        self._looks += 1
        if self._looks > LOOKS:
            self.wait(SHORTEST)
        return self.values[0]

    def sleep(self, seconds: float) -> None:
        """Wait so long."""
        self.wait(seconds)

    def wait(self, seconds: float, readable: Iterable[Any] = ()) -> list[Any]:
        """Wait so long (s) or until one of these files can be read; return those that can."""
        values, until = self.values, self.values[0] + max(seconds, SHORTEST)
        number, pipe = self._seat()
        self._looks = 0
        watched = (*readable, pipe)
        while True:
            values[number] = until
            ready, _, _ = _select(watched, (), ())
            values[number] = inf
            if pipe in ready:
                os.read(pipe, 64)
                ready.remove(pipe)
            if ready or values[0] >= until:
                return ready

    def _forget_seat(self) -> None:
        self._own = threading.local()

    def _seat(self) -> tuple[int, int]:
        """Return this thread's place among the values, and the pipe on which it is woken."""
        try:
            return self._own.seat
        except AttributeError:
            pass
        for number in range(1, MOST + 1):
            with contextlib.suppress(FileExistsError):
                os.mkfifo(pipe_of(self.folder, number))
                break
        else:
            raise RuntimeError(f"more than {MOST} threads")
        self._own.seat = (number, os.open(pipe_of(self.folder, number), os.O_RDWR))
        return self._own.seat


def create_time(folder: Path) -> None:
    """Make a time that starts with the kernel's."""
    folder.mkdir()
    with (folder / "time").open("wb") as file:
        file.truncate(_SIZE)
    values = SharedTime(folder).values
    for number in range(1, len(values)):
        values[number] = inf
    values[0] = time.monotonic()


def pipe_of(folder: Path, number: int) -> Path:
    """Return on what a thread is woken."""
    return folder / f"wake-{number}"
