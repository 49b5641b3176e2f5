"""The runs of a comparison, at the same time where they are simulated, and their end by Ctrl-C."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Final, NamedTuple

import click

from rig.runtime.ending_signals import all_as_ctrl_c
from rig.runtime.stop import ENDING

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing.queues import SimpleQueue
    from multiprocessing.synchronize import Event

    from rig.run_facts import RunStatus

INTERRUPTED: Final = 130
_PATIENCE: Final = 3.0
"""So long a simulated run may take to stop at once and close its books, s."""
_SETTLED: Final = 0.5
"""All books that are known of have been closed for so long: no run has just begun, s."""
_LOOK: Final = 0.05


class Job(NamedTuple):
    """One run of a comparison, as it can be handed to another process."""

    label: str
    experiment: str
    options: tuple[str, ...]
    rig: str | None
    configs: Path | None
    backend: str
    out: Path
    loop: str = ""  # what a linear model says of it; empty: nothing
    uncommissioned: str | None = None  # why hardware goes all out that is not commissioned


class Ended(NamedTuple):
    """A run that has ended.

    Parameters
    ----------
    path : Path
        Its folder.
    status : RunStatus
        As in its manifest.
    exit_code : int
        Of its command.
    message : str or None
        What ended it early.
    is_measured : bool
        Whether it has metrics.
    """

    path: Path
    status: RunStatus
    exit_code: int
    message: str | None
    is_measured: bool


class ComparedRuns(NamedTuple):
    """The runs that came to their end, and whether all were let."""

    ended: dict[str, Ended]
    interrupted: bool


class _Master(NamedTuple):
    """The lines between a process and those that run jobs for it."""

    started: SimpleQueue[tuple[str, Path]]
    """They say here which folder they work in."""
    stopping: Event
    """No job begins any more; the pool has handed out more than are running."""


class _Crew(NamedTuple):
    """Processes that run jobs, and the lines to them."""

    master: _Master
    pool: ProcessPoolExecutor


_master: list[_Master] = []
"""Of a process that runs jobs for another."""


def run_all(jobs: Sequence[Job], backend: str) -> ComparedRuns:
    """Run every job, simulated ones at the same time, until Ctrl-C.

    An interrupted run is not among those that ended: a simulated one is stopped at once, a physical
    one in the orderly way, and no other begins.
    """
    simulated = backend in ("sim", "virtual")
    workers = min(len(jobs), os.cpu_count() or 1) if simulated else 1
    ended: dict[str, Ended] = {}
    with all_as_ctrl_c():
        try:
            crew = _crew(workers) if workers > 1 else None
            if crew is None:
                for job in jobs:
                    ended[job.label] = _run(job, watched=True)
                    if ended[job.label].exit_code == INTERRUPTED:
                        del ended[job.label]
                        raise KeyboardInterrupt
            else:
                click.echo(f"{len(jobs)} runs, {workers} at a time …", err=True)
                _run_at_once(jobs, crew, ended)
        except KeyboardInterrupt:
            return ComparedRuns(ended, interrupted=True)
    return ComparedRuns(ended, interrupted=False)


def _crew(workers: int) -> _Crew | None:
    """Return what runs jobs in processes of their own; None: this machine has not the means."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    # A copy of this process has imported and compiled all that a run needs; a thread that is
    # copied in the middle of something would never come to its end.
    context = get_context("fork" if threading.active_count() == 1 else "spawn")
    try:
        with _deaf():  # what is begun here hears nothing of the terminal either
            master = _Master(context.SimpleQueue(), context.Event())
            pool = ProcessPoolExecutor(
                workers, mp_context=context, initializer=_leave_terminal, initargs=(master,)
            )
    except OSError as error:  # their locks and semaphores are files there
        why = error.strerror or error
        click.echo(f"the runs go one after the other: /dev/shm cannot be used: {why}", err=True)
        return None
    return _Crew(master, pool)


def _run_at_once(jobs: Sequence[Job], crew: _Crew, ended: dict[str, Ended]) -> None:
    """Run jobs in processes of their own; what has ended is noted, also when it is interrupted."""
    from concurrent.futures import as_completed

    master, pool = crew
    try:
        with _deaf():
            futures = {pool.submit(_run, job): job for job in jobs}
        for count, done in enumerate(as_completed(futures), 1):
            ended[futures[done].label] = done.result()
            said = f"{count} of {len(jobs)} done: {futures[done].label}: {done.result().path}"
            click.echo(said, err=True)
    except BaseException:
        with _deaf():
            pool.shutdown(wait=False, cancel_futures=True)
            folders = _stop_at_once(master)
            ended.update(_closed_before(folders, ended))
        raise
    pool.shutdown()


def _leave_terminal(master: _Master) -> None:
    """Begin a process that runs jobs: Ctrl-C is for the one that began it, and ends it, too."""
    from multiprocessing import parent_process

    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a copy has its master's
    for number in set(ENDING) - {signal.SIGINT}:
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    _master.append(master)
    parent = parent_process()
    assert parent is not None

    def follow() -> None:
        parent.join()
        os.killpg(0, signal.SIGKILL)

    threading.Thread(target=follow, daemon=True).start()


def _stop_at_once(master: _Master) -> dict[str, Path]:
    """Stop the runs of all processes, then end these; return the folder of each run that began."""
    from multiprocessing import active_children

    from rig.run_facts import RunStatus

    master.stopping.set()
    workers = [child.pid for child in active_children() if child.pid is not None]
    for _ in range(2):  # one stops a run in the orderly way
        for pid in workers:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGTERM)
        sleep(_LOOK)
    folders: dict[str, Path] = {}
    until = monotonic() + _PATIENCE
    closed = monotonic()
    while monotonic() < min(until, closed + _SETTLED):
        while not master.started.empty():
            label, path = master.started.get()
            folders[label] = path
        if any(_status_of(path) is RunStatus.RUNNING for path in folders.values()):
            closed = monotonic()
        sleep(_LOOK)
    for pid in workers:  # what draws figures for one is of its group
        with suppress(ProcessLookupError, PermissionError):
            os.kill(pid, signal.SIGKILL)
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(pid, signal.SIGKILL)
    return folders


def _status_of(path: Path) -> RunStatus:
    from rig.run_facts import RunStatus, read_manifest

    return RunStatus(read_manifest(path)["status"])


def _closed_before(
    folders: dict[str, Path], ended: dict[str, Ended]
) -> Iterator[tuple[str, Ended]]:
    """Yield the runs that had come to their end, and whose figures were being drawn."""
    from rig.run_facts import RunStatus
    from rig.run_folder import RunFolder

    for label, path in folders.items():
        if label in ended or _status_of(path) not in (RunStatus.OK, RunStatus.FAILED):
            continue
        folder = RunFolder.open(path)
        code = folder.manifest["exit_code"] or 0
        message = folder.manifest["message"]
        yield label, Ended(path, folder.status, code, message, bool(folder.metrics()))


@contextmanager
def _deaf() -> Iterator[None]:
    """Hold back Ctrl-C, which then comes after the block."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _run(job: Job, *, watched: bool = False) -> Ended:
    from rig.assembly import Backend
    from rig.cli.progress import ProgressLine
    from rig.experiment.plan import load_plan
    from rig.experiment.run import run_experiment
    from rig.experiment.watcher import Watcher

    class Telling(Watcher):
        """Tells the process that began this one which folder a run is in."""

        def started(self, path: Path) -> None:
            for master in _master:
                master.started.put((job.label, path))

    if any(master.stopping.is_set() for master in _master):
        raise KeyboardInterrupt
    plan = load_plan(job.experiment, job.options, rig=job.rig, configs=job.configs)
    backend = Backend(job.backend)
    if watched:
        with ProgressLine(job.label, job.backend) as line:
            result = run_experiment(
                plan, backend, job.out, overrides=job.options, watcher=line,
                uncommissioned=job.uncommissioned,
            )  # fmt: skip
    else:
        result = run_experiment(plan, backend, job.out, overrides=job.options, watcher=Telling())
    return Ended(result.path, result.status, result.exit_code, result.message, bool(result.metrics))
