"""Read the log of a run while it grows, without reading any of it twice."""

import os
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np

from rig.hal.columns import Column
from rig.runtime.log import OPCODE_DATA_END, LogError, LogFile, UnfinishedLog

if TYPE_CHECKING:
    from numpy.typing import NDArray

_END = bytes([OPCODE_DATA_END])

AT_ONCE = 1 << 20
"""Bytes that one reading takes at most: whoever reads has something else to do as well."""


class LogTail:
    """A log that somebody may still be writing, read from where the last reading ended.

    What is not there whole yet (the description of the columns, the last row of a process that
    was killed) is left for the next reading. Every row that is returned fits its checksum.

    Parameters
    ----------
    path : Path
        The ``log.mcap`` of a run folder; it need not exist yet.

    Attributes
    ----------
    columns : tuple of Column
        What a row's values are; empty until the file says so.
    count : int
        Rows that were returned.
    is_closed : bool
        Whether the index that a finished run writes was reached: there will be no more rows.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.columns: tuple[Column, ...] = ()
        self.count = 0
        self.is_closed = False
        self._file: LogFile | None = None
        self._fd = -1

    def read(self) -> "NDArray[np.void]":
        """Return the rows that were added since the last call, about `AT_ONCE` bytes at most.

        Returns
        -------
        ndarray
            With the fields of `LogFile.record`: ``cycle``, ``t`` (s), ``stamp`` (ns), ``row``.
            Empty if there is nothing new.

        Raises
        ------
        LogError
            It is no log, or damaged.
        """
        file = self._file or self._open()
        if file is None:
            return np.empty(0, np.dtype([("t", "<f8")]))
        size = file.record.itemsize
        most = max(AT_ONCE // size, 1) * size
        content = os.pread(self._fd, most, file.start + self.count * size)
        rows = file.rows_in(content, self.count)
        self.count += len(rows)
        rest = content[len(rows) * size :]
        if rest.startswith(_END):
            self.is_closed = True
        elif len(rest) >= size:
            raise LogError(f"the log {self.path} is damaged: row {self.count} is no whole message")
        return rows

    def rows(self, first: int, last: int) -> "NDArray[np.void]":
        """Return rows that `read` has returned before, from `first` up to but without `last`."""
        if self._file is None:
            raise LogError(f"{self.path} has not been read yet")
        size = self._file.record.itemsize
        first, last = max(first, 0), min(last, self.count)
        content = os.pread(self._fd, max(last - first, 0) * size, self._file.start + first * size)
        return np.frombuffer(content, self._file.record, len(content) // size)

    def close(self) -> None:
        """Let go of the file. Idempotent."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def __enter__(self) -> "LogTail":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _open(self) -> LogFile | None:
        if not self.path.exists():
            return None
        try:
            self._file = LogFile(self.path)
        except UnfinishedLog:
            return None
        self._fd = os.open(self.path, os.O_RDONLY)
        self.columns = self._file.columns
        return self._file
