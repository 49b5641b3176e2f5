"""The columns of a log that is too long for the memory: laid side by side in a file of their own.

A log's file has its rows side by side. Whoever judges or draws a run wants whole columns, some of
them, one after the other: each stands here in one piece, whose pages are read when they are looked
at.
"""

import contextlib
import errno
import mmap
import os
import tempfile
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

from rig.hal.columns import Column
from rig.runtime import long_array
from rig.runtime.log import LogFile, no_such_column, whole_log

if TYPE_CHECKING:
    from numpy.typing import NDArray

Number = TypeVar("Number", bound=np.generic)

_SHORT = 64 << 20
"""A log of so many bytes is held in memory: to lay out its columns would take longer."""
_NUMBER_SIZE = 8
_OF_ALL = ("cycle", "t", "stamp")
"""Fields of a row beside its columns; they are laid first."""
_PIECE = 1 << 16
"""Numbers of a column that are read in one go where it is not wanted whole."""
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM, errno.EFBIG)


class LogColumns(Protocol):
    """A run's columns, in memory or not; see `rig.runtime.log.Log`."""

    @property
    def columns(self) -> tuple[Column, ...]:
        """What there is beside `cycle`, `t` and `stamp`."""

    @property
    def cycle(self) -> "NDArray[np.uint64]":
        """Number of each cycle, shape (n,)."""

    @property
    def t(self) -> "NDArray[np.float64]":
        """Time on the rig's clock, s, shape (n,)."""

    @property
    def stamp(self) -> "NDArray[np.uint64]":
        """Wall-clock time, ns since the epoch, shape (n,)."""

    @property
    def complete(self) -> bool:
        """Whether the file was closed."""

    def __contains__(self, name: object) -> bool: ...

    def column(self, name: str) -> "NDArray[np.float64]":
        """Return one column, SI, shape (n,); LogError if there is none."""

    def names(self, prefix: str) -> tuple[str, ...]:
        """Return the names of the columns that start with `prefix`, in order."""

    @property
    def rows(self) -> int:
        """How many there are."""

    def pieces(self, name: str) -> "Iterator[NDArray[np.uint64] | NDArray[np.float64]]":
        """Yield ``cycle``, ``t``, ``stamp`` or a column by its name, one stretch after another."""


def read_columns(path: str | Path) -> LogColumns:
    """Read a log, in memory that does not grow with its columns.

    Parameters
    ----------
    path : Path
        The ``log.mcap`` of a run folder. A long one takes as much again of the disk, beside it or
        in the folder for temporary files, for as long as the columns are in use.

    Raises
    ------
    LogError
        See `LogFile`.
    """
    return columns_of(LogFile(path))


def columns_of(file: LogFile) -> LogColumns:
    """Return the columns of a log that has been opened; see `read_columns`."""
    if file.room * file.record.itemsize > _SHORT:
        for folder in (file.path.parent, Path(tempfile.gettempdir())):
            with _skipped_if_full():
                return FiledColumns(file, folder)
    return whole_log(file)


@contextlib.contextmanager
def _skipped_if_full() -> Iterator[None]:
    """Go on where nothing can be written: the log itself is not in question."""
    try:
        yield
    except OSError as error:
        if error.errno not in _NO_ROOM:
            raise


class FiledColumns:
    """Columns in a nameless file, which is gone with this object and its process.

    Parameters
    ----------
    file : LogFile
        Read once, row by row.
    folder : Path
        Where the columns are laid.

    Raises
    ------
    LogError
        The log is damaged.
    OSError
        The folder takes no such file.
    """

    def __init__(self, file: LogFile, folder: Path) -> None:
        self.columns = file.columns
        self._folder = folder
        # A column begins where a page does.
        page = mmap.ALLOCATIONGRANULARITY // _NUMBER_SIZE
        self._room = -(-file.room // page) * page
        with tempfile.TemporaryFile(dir=folder) as nameless:
            self._store = os.dup(nameless.fileno())
        weakref.finalize(self, os.close, self._store)
        self._places = {column.name: k for k, column in enumerate(self.columns, len(_OF_ALL))}
        self._count = 0
        for rows in file.pieces():
            for place, name in enumerate(_OF_ALL):
                self._put(place, rows[name])
            for k in range(len(self.columns)):
                self._put(len(_OF_ALL) + k, rows["row"][:, k])
            self._count += len(rows)
        self.complete = file.complete

    @property
    def cycle(self) -> "NDArray[np.uint64]":
        """Number of each cycle, shape (n,)."""
        return self._whole(_OF_ALL.index("cycle"), np.uint64)

    @property
    def t(self) -> "NDArray[np.float64]":
        """Time on the rig's clock, s, shape (n,)."""
        return self._whole(_OF_ALL.index("t"), np.float64)

    @property
    def stamp(self) -> "NDArray[np.uint64]":
        """Wall-clock time, ns since the epoch, shape (n,)."""
        return self._whole(_OF_ALL.index("stamp"), np.uint64)

    def __contains__(self, name: object) -> bool:
        return name in self._places

    def column(self, name: str) -> "NDArray[np.float64]":
        """Return one column, SI, shape (n,), read anew: changing it changes nothing else.

        Raises
        ------
        LogError
            There is no such column.
        """
        if name not in self._places:
            raise no_such_column(name, self.columns)
        return self._whole(self._places[name], np.float64)

    def names(self, prefix: str) -> tuple[str, ...]:
        """Return the names of the columns that start with `prefix`, in order."""
        return tuple(c.name for c in self.columns if c.name.startswith(prefix))

    @property
    def rows(self) -> int:
        """How many there are."""
        return self._count

    def pieces(self, name: str) -> "Iterator[NDArray[np.uint64] | NDArray[np.float64]]":
        """Yield ``cycle``, ``t``, ``stamp`` or a column by its name, one stretch after another.

        Raises
        ------
        LogError
            There is no such column.
        """
        place = self._places.get(name)
        is_whole_number = place is None and name in ("cycle", "stamp")
        if place is None:
            if name not in _OF_ALL:
                raise no_such_column(name, self.columns)
            place = _OF_ALL.index(name)
        for start in range(0, self._count, _PIECE):
            count = min(_PIECE, self._count - start)
            if is_whole_number:
                yield self._read(place, np.uint64, start, count)
            else:
                yield self._read(place, np.float64, start, count)

    def _put(self, place: int, values: "NDArray[np.generic]") -> None:
        offset = _NUMBER_SIZE * (place * self._room + self._count)
        left = memoryview(values.tobytes())
        while left:
            taken = os.pwrite(self._store, left, offset)
            left, offset = left[taken:], offset + taken

    def _whole(self, place: int, kind: "type[Number]") -> "NDArray[Number]":
        if self._count * _NUMBER_SIZE < long_array.LONG:
            return self._read(place, kind, 0, self._count)
        start = _NUMBER_SIZE * place * self._room
        return long_array.mapped(self._folder, self._store, start, self._count, kind)

    def _read(self, place: int, kind: "type[Number]", start: int, count: int) -> "NDArray[Number]":
        found = np.empty(count, kind)
        # Not by the file's own position: processes that draw figures share it.
        left = found.view(np.uint8).data
        offset = _NUMBER_SIZE * (place * self._room + start)
        while left:
            taken = os.preadv(self._store, [left], offset)
            left, offset = left[taken:], offset + taken
        return found
