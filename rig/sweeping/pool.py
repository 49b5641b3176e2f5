"""Processes of this machine that run points, and stay warm between them."""

import contextlib
import os
import socket
import subprocess
import sys
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Final

from rig.plug_ins import packages_that_take_part
from rig.sweeping.engine import PointReport, WorkerSetup
from rig.sweeping.errors import SweepStopped
from rig.sweeping.point import PointJob
from rig.sweeping.server import READY, send_setup

_ONE_THREAD: Final = (
    "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM",
    "NUMBA_NUM_THREADS",
)  # fmt: skip
"""A worker is one processor's work; threads beside it would take another worker's."""


class Pool:
    """Workers of this machine: copies of one process, each with a socket of its own.

    Parameters
    ----------
    workers : int
        How many.
    setup : WorkerSetup
        What they need.

    Raises
    ------
    SweepStopped
        They cannot be started.
    """

    def __init__(self, workers: int, setup: WorkerSetup) -> None:
        self._setup = setup
        self._process, self._control = _start(setup)
        self._idle = [self._hire() for _ in range(workers)]
        self._busy: dict[Connection, str] = {}
        self.slots = workers

    def submit(self, job: PointJob) -> None:
        """Hand a point to an idle worker."""
        while True:
            connection = self._idle.pop()
            try:
                connection.send(job)
            except OSError:  # it died while it had nothing to do
                self._idle.append(self._replace(connection))
            else:
                break
        self._busy[connection] = job.name

    def wait(self, timeout: float) -> list[PointReport]:
        """Return what workers say, and which of them died."""
        reports = []
        for ready in wait(list(self._busy), timeout):
            assert isinstance(ready, Connection)
            name = self._busy.pop(ready)
            try:
                reports.append(ready.recv())
                self._idle.append(ready)
            except (EOFError, OSError):
                reports.append(PointReport(name, died=True))
                self._idle.append(self._replace(ready))
        return reports

    def close(self) -> None:
        """End every worker."""
        self._control.close()
        for connection in (*self._idle, *self._busy):
            connection.close()
        self._process.wait()

    def _replace(self, connection: Connection) -> Connection:
        connection.close()
        return self._hire()

    def _hire(self) -> Connection:
        try:
            return self._fork()
        except OSError:  # the server died as well
            self._control.close()
            self._process.wait()
            self._process, self._control = _start(self._setup)
            return self._fork()

    def _fork(self) -> Connection:
        ours, theirs = socket.socketpair()
        with theirs:
            try:
                socket.send_fds(self._control, [b"+"], [theirs.fileno()])
            except OSError:
                ours.close()
                raise
        return Connection(ours.detach())


def _start(setup: WorkerSetup) -> tuple["subprocess.Popen[bytes]", socket.socket]:
    ours, theirs = socket.socketpair()
    path = os.pathsep.join(entry or str(Path.cwd()) for entry in sys.path)
    environment = {**os.environ, **dict.fromkeys(_ONE_THREAD, "1"), "PYTHONPATH": path}
    with theirs:
        process = _start_server(theirs.fileno(), environment)
    with contextlib.suppress(OSError):
        send_setup(ours, setup._replace(packages=packages_that_take_part()))
    answer = ours.recv(4096)
    if answer != READY:
        ours.close()
        process.kill()
        process.wait()
        why = answer.decode(errors="replace") or f"it ended with {process.returncode}"
        raise SweepStopped("workers", f"cannot be started: {why}")
    return process, ours


def _start_server(descriptor: int, environment: dict[str, str]) -> "subprocess.Popen[bytes]":
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "rig.sweeping.server", str(descriptor)],
        pass_fds=[descriptor], env=environment,
        start_new_session=True,  # Ctrl-C is for the sweep, which ends its workers
    )  # fmt: skip
