"""Processes that work on several things at once and tell what comes of each."""

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import Connection, wait
from typing import Any, TypeVar

from rig.runtime.parent import die_with_parent

Task = TypeVar("Task")

Tell = Callable[[object], None]


def share_out(
    tasks: Sequence[Task], work: Callable[[Task, Tell], None], workers: int
) -> Iterator[Any]:
    """Yield what processes tell of their tasks, as it comes.

    Parameters
    ----------
    tasks : sequence
        A process each; what is imported and compiled here is there.
    work : callable
        Does one task, and tells what comes of it. A process that dies has told what it has told.
    workers : int
        How many at once.
    """
    context = multiprocessing.get_context("fork")
    waiting = list(tasks)[::-1]
    running: list[Connection] = []
    while waiting or running:
        while waiting and len(running) < workers:
            receiver, sender = context.Pipe(duplex=False)
            task = waiting.pop()
            context.Process(target=_work, args=(work, task, sender), daemon=True).start()
            sender.close()
            running.append(receiver)
        ready = wait(running)
        for receiver in [one for one in running if one in ready]:
            try:
                told = receiver.recv()
            except EOFError:
                running.remove(receiver)
                continue
            yield told


def _work(work: Callable[[Task, Tell], None], task: Task, sender: Connection) -> None:
    """Do one task in this process, silently."""
    die_with_parent()
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    work(task, sender.send)
