"""One line on a terminal that is drawn again and again."""

import contextlib
import os
import sys
from typing import Self

from rig.terminals import is_terminal


class TerminalLine:
    """One line on stderr; where that is no terminal, nothing is drawn.

    The line is written to a descriptor that never blocks: a terminal that is stopped (Ctrl-S)
    or slow must stop neither a loop nor devices.
    """

    def __init__(self) -> None:
        self._fd: int | None = None

    def __enter__(self) -> Self:
        if is_terminal(sys.stderr):
            with contextlib.suppress(OSError):  # a console without a name
                self._fd = os.open(
                    os.ttyname(sys.stderr.fileno()), os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY
                )
        return self

    def __exit__(self, *_: object) -> None:
        self.draw("")
        if self._fd is not None:
            os.close(self._fd)
            self._fd = None

    @property
    def is_seen(self) -> bool:
        """Whether there is a terminal."""
        return self._fd is not None

    def draw(self, text: str) -> None:
        """Draw the line anew; an empty one is taken away."""
        if self._fd is not None:
            with contextlib.suppress(OSError):  # full or gone: the next redraw may get through
                os.write(self._fd, f"\r\x1b[2K{text}".encode())
