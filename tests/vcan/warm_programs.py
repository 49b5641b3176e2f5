"""Start `rig` commands from a process that has imported everything already.

In user-mode Linux the imports of one command take several seconds, and the tests start fifty.
Each is a process of its own all the same, which inherits nothing but the modules.
"""

import atexit
import os
import subprocess
import sys
from multiprocessing import get_context
from multiprocessing.connection import Connection


class WarmProcess:
    """A command in such a process, with as much of `subprocess.Popen` as tests need.

    Parameters
    ----------
    arguments : list of str
        What follows ``rig``.
    environment : dict of str to str
        Variables that it has besides.
    """

    def __init__(self, arguments: list[str], environment: dict[str, str]) -> None:
        context = get_context("forkserver")
        context.set_forkserver_preload(["all_of_rig"])
        out, err = context.Pipe(duplex=False), context.Pipe(duplex=False)
        given = (arguments, out[1], err[1], environment)
        self._process = context.Process(target=_be_rig, args=given)
        self._process.start()
        self.pid = self._process.pid
        self.stdout, self.stderr = (_open_text(ends) for ends in (out, err))

    @property
    def returncode(self) -> int | None:
        return self._process.exitcode

    poll = returncode.fget

    def wait(self, timeout: float | None = None) -> int:
        self._process.join(timeout)
        code = self._process.exitcode
        if code is None:
            raise subprocess.TimeoutExpired("rig", timeout)
        return code

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        self._process.kill()


def _open_text(ends: tuple[Connection, Connection]):
    """Return what reads a pipe whose other end belongs to the process now."""
    reading, writing = ends
    writing.close()
    with reading:
        return os.fdopen(os.dup(reading.fileno()), encoding="utf-8")


def _be_rig(
    arguments: list[str], out: Connection, err: Connection, environment: dict[str, str]
) -> None:
    os.environ.update(environment)
    os.dup2(out.fileno(), 1)
    os.dup2(err.fileno(), 2)
    out.close()
    err.close()
    sys.argv = ["rig", *arguments]
    if "WATCHED_TRUTH" in environment:
        from watched_rig import watch

        watch(environment["WATCHED_TRUTH"])
    from rig.cli import main

    try:
        main()
    finally:
        atexit._run_exitfuncs()
