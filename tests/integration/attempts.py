"""A command in a process of its own, with a bound of its processor time, memory and patience."""

import contextlib
import os
import resource
import signal
import sys
import time
import traceback
from pathlib import Path
from typing import NamedTuple

PATIENCE = 30.0  # s of the wall's clock in which nothing was computed
ROOM = 1 << 30  # bytes beyond what the process holds already


class Attempt(NamedTuple):
    """What came of a command."""

    code: int
    """Its exit code; below 0 the signal that ended it."""
    out: str
    err: str
    spent: float
    """Processor time of it and its children, s."""

    def trouble(self, longest):
        """Return what no file may lead to, if anything."""
        if self.code == -signal.SIGALRM:
            return f"waits, and computes nothing for {PATIENCE:g} s"
        if self.code == -signal.SIGXCPU or self.spent > longest:
            return f"takes {self.spent:.1f} s of the processor"
        if self.code not in (0, 1, 2, 3, 4):
            return f"exit code {self.code}: {self.err[-2000:]}"
        if "Traceback" in self.out + self.err or "bug in rig" in self.err:
            return f"a traceback: {self.err[-2000:]}"
        if "\x1b" in self.out + self.err or "\x07" in self.out + self.err:
            return "an escape sequence reaches the terminal"
        if len(self.err) > 200_000:
            return f"{len(self.err)} characters of talk"
        return None


def attempt(call, folder, longest=30.0, environment=None):
    """Call something in a fork.

    Parameters
    ----------
    call : callable
        Returns an exit code.
    folder : Path
        Where it works; its output is kept beside it.
    longest : float
        Processor time that it may take, s.
    environment : mapping, optional
        Variables of its own; None takes one away.
    """
    out, err = (folder.parent / f"{folder.name}.{name}" for name in ("out", "err"))
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child == 0:
        code = 98
        try:
            _confine(out, err, folder, longest)
            for name, value in (environment or {}).items():
                os.environ.pop(name, None)
                if value is not None:
                    os.environ[name] = value
            code = call()
        except SystemExit as left:
            code = left.code if isinstance(left.code, int) else 97
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code or 0)
    status, used = _await(child)
    spent = used.ru_utime + used.ru_stime
    return Attempt(
        os.waitstatus_to_exitcode(status), out.read_text(errors="replace"),
        err.read_text(errors="replace"), spent,
    )  # fmt: skip


def _await(child):
    """Wait for the end of a process; end what does nothing at all for a while."""
    spent, since = -1.0, time.monotonic()
    while True:
        found, status, used = os.wait4(child, os.WNOHANG)
        if found:
            return status, used
        time.sleep(0.02 if time.monotonic() < since + 1.0 else 0.5)
        if time.monotonic() > since + 1.0 and (now := _spent_in(child)) != spent:
            spent, since = now, time.monotonic()
        elif time.monotonic() > since + PATIENCE:
            os.killpg(child, signal.SIGALRM)


def _spent_in(session):
    """Return what the processes of a session have used, in clock ticks."""
    total = 0
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            fields = path.read_text().rpartition(") ")[2].split()
            if int(fields[3]) == session:
                total += int(fields[11]) + int(fields[12])
    return total


def _confine(out, err, folder, longest):
    os.setsid()
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    seconds = int(longest) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    [line] = [s for s in Path("/proc/self/status").read_text().splitlines() if "VmData" in s]
    most = int(line.split()[1]) * 1024 + ROOM
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 28, 1 << 28))
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    for number, path in ((1, out), (2, err)):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644), number)
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115
    os.chdir(folder)
