"""Programs in processes of their own, without the seconds that their imports take.

A process is forked from one that has imported everything and done nothing (`warm_server`). It has
its own memory, streams, folder, environment and end. What imports cost or do, and how Python
itself starts, shows only where Python is started.
"""

import atexit
import contextlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

RIG = "from rig.cli import main; main()"
"""The program of the command line."""
PATIENCE = 600.0
"""After which a process that hangs is killed, s."""


@cache
def _server():
    """Start the process that all others are forked from."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with theirs:
        program = [sys.executable, Path(__file__).with_name("warm_server.py"), str(theirs.fileno())]
        null = subprocess.DEVNULL
        process = subprocess.Popen(program, pass_fds=[theirs.fileno()], stdin=null, stdout=null)
    atexit.register(process.wait)
    atexit.register(ours.close)  # first: it ends when nobody can ask any more
    return ours


class WarmProcess:
    """A process of its own, with as much of `subprocess.Popen` as tests need.

    Parameters
    ----------
    words : sequence
        Arguments.
    program : str
        Python's text; default: the command line.
    stdout, stderr : int or file
        Where its output goes.
    folder : Path, optional
        Where it runs; default: here.
    environment : mapping, optional
        All its variables; default: this process's.
    more : sequence of int
        What it has open besides, as 3 and the next.
    """

    def __init__(
        self, words=(), program=RIG, *, stdout, stderr, folder=None, environment=None, more=()
    ):
        environment = dict(os.environ if environment is None else environment)
        asked = {
            "words": [*map(str, words)], "program": program,
            "folder": str(folder or Path.cwd()), "environment": environment,
        }  # fmt: skip
        told, tell = os.pipe()
        self._told = os.fdopen(told)
        self.returncode = None
        ends = [end if isinstance(end, int) else end.fileno() for end in (stdout, stderr)]
        with Path(os.devnull).open() as null:
            given = [null.fileno(), *ends, *more, tell]
            socket.send_fds(_server(), [json.dumps(asked).encode()], given)
        os.close(tell)
        self.pid = int(self._told.readline())

    def wait(self):
        """Return its exit code once it has ended; negative: the signal that ended it."""
        if self.returncode is None:
            if not select.select([self._told], [], [], PATIENCE)[0]:
                self.kill()
            self.returncode = int(self._told.readline())
            self._told.close()
        return self.returncode

    def send_signal(self, number):
        """Send it a signal, if it has not ended."""
        if self.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)

    def kill(self):
        """End it at once."""
        self.send_signal(signal.SIGKILL)


def run(words=(), program=RIG, *, folder=None, environment=None):
    """Run a program to its end; return its exit code and what it said, as `subprocess.run` does."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        process = WarmProcess(
            words, program, stdout=out, stderr=err, folder=folder, environment=environment
        )
        code = process.wait()
        said = []
        for stream in (out, err):
            stream.seek(0)
            said.append(stream.read())
    return subprocess.CompletedProcess([*words], code, *said)
