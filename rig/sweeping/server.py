"""A process that has everything imported, and of which workers are copies.

``python -m rig.sweeping.server FD`` is started once for each pool. It reads its `WorkerSetup`,
imports all that a run might, and then becomes a worker for each socket that it is sent. The code
that it has imported is the code that every worker runs, however late it begins.
"""

import contextlib
import os
import pickle
import signal
import socket
import sys
from multiprocessing.connection import Connection
from pathlib import Path

from rig.assembly.rows import load
from rig.installation import missing_package
from rig.runtime.parent import end_with
from rig.sweeping.code import code_version, import_all
from rig.sweeping.engine import Perform, PointReport, WorkerSetup
from rig.sweeping.errors import SweepStopped

READY = b"ready"


def main(descriptor: int) -> None:
    """Serve until the other end is closed."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for workers: their sockets tell
    control = socket.socket(fileno=descriptor)
    setup = receive_setup(control)
    _speak_into(setup.log)
    import_all(setup.packages)
    perform: Perform = load(setup.perform)
    if setup.code and code_version().digest != setup.code:
        control.sendall(b"the source changed, or is another one than that of the sweep")
        return
    control.sendall(READY)
    server = os.getpid()
    while True:
        message, sockets, _, _ = socket.recv_fds(control, 1, 1)
        if not message:
            break
        if os.fork() == 0:
            control.close()
            end_with(server, signal.SIGKILL)
            _work(Connection(sockets[0]), perform)
            os._exit(0)
        os.close(sockets[0])
    with contextlib.suppress(OSError):
        os.killpg(0, signal.SIGKILL)  # workers too: they have nobody to tell


def send_setup(control: socket.socket, setup: WorkerSetup) -> None:
    """Send what workers need."""
    content = pickle.dumps(setup)
    control.sendall(len(content).to_bytes(8, "big") + content)


def receive_setup(control: socket.socket) -> WorkerSetup:
    """Receive what workers need; it comes from the process that started this one."""
    size = int.from_bytes(_receive(control, 8), "big")
    setup: WorkerSetup = pickle.loads(_receive(control, size))
    return setup


def _receive(control: socket.socket, size: int) -> bytes:
    content = b""
    while len(content) < size:
        part = control.recv(size - len(content))
        if not part:
            raise SystemExit(0)
        content += part
    return content


def _work(connection: Connection, perform: Perform) -> None:
    """Run points until the other end is closed."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    with contextlib.suppress(EOFError, OSError):
        while True:
            job = connection.recv()
            try:
                report = PointReport(job.name, finding=perform(job))
            except SweepStopped as error:
                report = PointReport(job.name, trouble=error.what)
            except ModuleNotFoundError as error:
                if (lacking := missing_package(error)) is None:
                    raise
                report = PointReport(job.name, trouble=lacking)
            connection.send(report)


def _speak_into(log: Path | None) -> None:
    nowhere = os.open(os.devnull, os.O_RDWR)
    with contextlib.suppress(OSError):
        where = (
            nowhere if log is None else os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        )
        os.dup2(where, 2)
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)


if __name__ == "__main__":
    main(int(sys.argv[1]))
