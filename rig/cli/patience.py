"""A word for whoever waits at a terminal while something takes long."""

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import click

from rig.terminals import is_terminal

_SOON = 2.0
"""Nobody is told what is done by then, s."""


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
