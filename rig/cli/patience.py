"""A word for whoever waits while something takes long."""

import logging
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from rig.cli.terminal_line import TerminalLine
from rig.terminals import is_terminal

_SOON = 2.0
"""Nobody is told what is done by then, s."""
_LONG_LOG = 32 << 20
"""What is made of a log of so many bytes takes seconds."""
_KERNELS = "controllers.kernel_files"
"""Who tells its logger of what it compiles. Plants use it too, and so it knows nothing of rig."""


@contextmanager
def told_if_long(words: str) -> Iterator[None]:
    """Say what is worked out if that takes long; into a pipe or a file nothing is said."""
    if not is_terminal(sys.stderr):
        yield
        return
    timer = threading.Timer(_SOON, click.echo, (f"{words} …",), {"err": True})
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()  # what comes next may copy this process, which it can while it is alone


@contextmanager
def told_of_log(words: str, log: Path) -> Iterator[None]:
    """Say what is made of a log: on a terminal until it is done, elsewhere of a long log alone."""
    with TerminalLine() as line:
        line.draw(f"{words} …")
        if not line.is_seen and log.is_file() and log.stat().st_size >= _LONG_LOG:
            click.echo(f"{words} …", err=True)
        yield


@contextmanager
def told_of_compiling() -> Iterator[None]:
    """Say that kernels are compiled, when the first one is whose file is not there."""
    logger, teller = logging.getLogger(_KERNELS), _Compiling()
    level, propagates = logger.level, logger.propagate
    logger.setLevel(logging.INFO)
    logger.propagate = False
    logger.addHandler(teller)
    try:
        yield
    finally:
        logger.removeHandler(teller)
        logger.propagate = propagates
        logger.setLevel(level)


class _Compiling(logging.Handler):
    """Says it once, and not in copies of this process."""

    def __init__(self) -> None:
        super().__init__()
        self._process: int | None = os.getpid()

    def emit(self, record: logging.LogRecord) -> None:
        """Say it; a progress line makes room."""
        if self._process != os.getpid():
            return
        self._process = None
        start = "\r\x1b[2K" if is_terminal(sys.stderr) else ""
        click.echo(f"{start}{record.getMessage()} …", err=True)
