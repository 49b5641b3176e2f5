"""Room on a disk that is kept free for last words."""

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Final

_SIZE: Final = 64 * 1024
"""Bytes: some events, ``timing.json`` and a manifest take a tenth of it."""


class SpareRoom:
    """Room that a run takes at its start, and gives back when the disk is full.

    A full disk ends a run; that it did must still find room in its events and its manifest.

    Parameters
    ----------
    folder : Path
        The run folder.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / ".spare"

    def take(self) -> None:
        """Take the room.

        Raises
        ------
        OSError
            There is not even that much.
        """
        descriptor = os.open(
            self._path, os.O_WRONLY | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o644
        )
        try:
            os.posix_fallocate(descriptor, 0, _SIZE)
        finally:
            os.close(descriptor)

    def helping(self, write: Callable[[], None]) -> None:
        """Call what writes; if the disk is full, once more with the room given back.

        Raises
        ------
        OSError
            It cannot be written even so.
        """
        try:
            write()
        except OSError:
            if not self.give_back():
                raise
            write()

    def give_back(self) -> bool:
        """Give the room back; return whether there was any."""
        try:
            self._path.unlink()
        except OSError:
            return False
        return True


def append_line(descriptor: int, line: bytes) -> None:
    """Append a line, whole or not at all.

    Raises
    ------
    OSError
        It does not fit.
    """
    written = os.write(descriptor, line)
    if written < len(line):
        os.ftruncate(descriptor, os.fstat(descriptor).st_size - written)
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
