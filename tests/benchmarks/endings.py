"""How a program that measures ends: its exit code says what it found, or that it found nothing.

2 with a sentence if it could not measure, or not write what it found; 130 if it was interrupted, by
whatever signal; 70 with a traceback for a bug in it. What it made meanwhile is taken away.
"""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from rig.runtime.ending_signals import all_as_ctrl_c
from rig.runtime.stop import ENDING

UNMEASURED, BUG, INTERRUPTED = 2, 70, 130
_CLOSED = "stdout", "stderr"
_OFTEN = 0.005
"""Between two looks at a command that runs, s."""
_signals = contextlib.ExitStack()


class Unmeasured(Exception):
    """Says in a sentence why nothing can be measured."""


def take_over():
    """See to every end of this program, from now on: to be called before what is slow to import."""
    for name in _CLOSED:
        if getattr(sys, name) is None:  # closed by the shell: nobody wants it
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115
    _signals.enter_context(all_as_ctrl_c())
    sys.excepthook = _end


def end(code):
    """End with this code; instead of 0 with 2 if what was found cannot be written."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:  # its reader has seen enough
        _drop_output()
    except OSError as error:
        _drop_output()
        talk(f"cannot write what was measured: {error.strerror}")
        code = code or UNMEASURED
    sys.exit(code)


def _end(kind, error, trace):
    """End by an error that nobody took."""
    if issubclass(kind, KeyboardInterrupt):
        talk("Interrupted.")
        end(INTERRUPTED)
    if issubclass(kind, BrokenPipeError):
        end(UNMEASURED)
    if issubclass(kind, OSError):
        where = f": {error.filename}" if error.filename is not None else ""
        error = Unmeasured(f"cannot go on: {error.strerror}{where}")
    if isinstance(error, Unmeasured):
        talk(str(error))
        end(UNMEASURED)
    sys.__excepthook__(kind, error, trace)
    end(BUG)


def _drop_output():
    """Let Python not try once more."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def talk(text):
    """Say something to whoever measures, if they still listen."""
    with contextlib.suppress(OSError):
        sys.stderr.write(f"{text}\n")
        sys.stderr.flush()


@contextlib.contextmanager
def unheard():
    """Take what was made away without being interrupted in it."""
    before = {number: signal.signal(number, signal.SIG_IGN) for number in ENDING}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def folder_for_a_while(prefix, within=None):
    """Yield a new folder, and take it away again with all that is in it."""
    folder = Path(tempfile.mkdtemp(prefix=prefix, dir=within))
    try:
        yield folder
    finally:
        with unheard():
            shutil.rmtree(folder, ignore_errors=True)


def called(*words, look=None, **how):
    """Run a command; nothing that it began goes on behind an interrupt.

    It has a group of processes of its own: Ctrl-C in the terminal comes to this program alone.
    `look` is called with its number again and again while it runs; its output has to be short then.
    """
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, process_group=0, **how
    ) as process:
        try:
            while look is not None and process.poll() is None:
                look(process.pid)
                time.sleep(_OFTEN)
            said = process.communicate()
        except BaseException:
            with unheard(), contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
                process.communicate()  # until the last of them has let go of its output
            raise
    return subprocess.CompletedProcess(words, process.returncode, *said)


def last_line(ended):
    """Return what a command said at its end, or how it ended if it said nothing."""
    lines = ended.stderr.strip().splitlines()
    return lines[-1] if lines else f"exit code {ended.returncode}"
