"""Read the log of a run, finished or not."""

import os
import struct
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

import numpy as np

from rig.hal import ConfigurationError
from rig.hal.columns import Column
from rig.hal.files import open_regular
from rig.runtime.mcap_file import CHANNEL_ID, MAGIC, decode_channel
from rig.runtime.recorder import CHECKSUM_SIZE, OPCODE_MESSAGE, RECORD_HEAD, RECORD_PREFIX

if TYPE_CHECKING:
    from numpy.typing import NDArray

_OPCODE_CHANNEL = 0x04
OPCODE_DATA_END = 0x0F
_DATA_END_SIZE = RECORD_PREFIX + 4
_FOOTER = struct.Struct("<BQQQI")
_AT_ONCE = 4 << 20
"""Bytes of a log that are read in one go."""
_LONGEST_PREAMBLE = 64 << 20
"""No description of columns is longer, bytes; a length beyond it is a damaged one."""


class LogError(ConfigurationError):
    """A file is not a log of this program, or is damaged."""


class UnfinishedLog(LogError):
    """A file ends before its columns are described: somebody may still be writing that."""


class Log(NamedTuple):
    """All rows of a run.

    Parameters
    ----------
    columns : tuple of Column
        What `values` holds, shape (k,).
    cycle : ndarray of int
        Number of each cycle, shape (n,).
    t : ndarray
        Time on the rig's clock, s, shape (n,).
    values : ndarray
        SI, shape (n, k).
    stamp : ndarray of int
        Wall-clock time, ns since the epoch, shape (n,).
    complete : bool
        Whether the file was closed: False while it is recorded and for ever if the recording
        process was killed.
    """

    columns: tuple[Column, ...]
    cycle: "NDArray[np.uint64]"
    t: "NDArray[np.float64]"
    values: "NDArray[np.float64]"
    stamp: "NDArray[np.uint64]"
    complete: bool

    def __contains__(self, name: object) -> bool:
        return any(column.name == name for column in self.columns)

    def column(self, name: str) -> "NDArray[np.float64]":
        """Return one column, shape (n,).

        Raises
        ------
        LogError
            There is no such column.
        """
        for index, column in enumerate(self.columns):
            if column.name == name:
                return self.values[:, index]
        raise no_such_column(name, self.columns)

    def names(self, prefix: str) -> tuple[str, ...]:
        """Return the names of the columns that start with `prefix`, in order."""
        return tuple(c.name for c in self.columns if c.name.startswith(prefix))

    @property
    def rows(self) -> int:
        """How many there are."""
        return len(self.t)

    def pieces(self, name: str) -> "Iterator[NDArray[np.uint64] | NDArray[np.float64]]":
        """Yield ``cycle``, ``t``, ``stamp`` or a column by its name: here in one piece."""
        if name in self:
            yield self.column(name)
        elif name == "t":
            yield self.t
        else:
            yield {"cycle": self.cycle, "stamp": self.stamp}[name]


def no_such_column(name: str, columns: Sequence[Column]) -> LogError:
    """Return the error that a log has other columns than the one asked for."""
    known = ", ".join(column.name for column in columns)
    return LogError(f"the log has no column {name!r}; it has {known}")


class LogFile:
    """A log on disk, read piece by piece: what it takes of memory does not grow with the run.

    All messages have one length and stand side by side, so that they are rows of an array.

    Parameters
    ----------
    path : Path
        The ``log.mcap`` of a run folder, also of a run that goes on or was killed.

    Attributes
    ----------
    columns : tuple of Column
        What a row's values are.
    start : int
        Where in the file the first row stands, bytes.
    record : dtype
        A row as it stands in the file.
    room : int
        No more rows than these are in the file.
    complete : bool
        Whether the file was closed; known when all pieces have been read.

    Raises
    ------
    LogError
        The file cannot be read, is not MCAP, or does not describe its columns.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.complete = False
        with self._opened() as stream:
            self.columns, self.start, self._begun = _read_preamble(self.path, stream)
            self._size = os.fstat(stream.fileno()).st_size
        head = struct.calcsize(RECORD_HEAD)
        fields = {
            "opcode": ("u1", 0), "length": ("<u8", 1), "channel": ("<u2", 9),
            "sequence": ("<u4", 11), "stamp": ("<u8", 15), "cycle": ("<u8", head - 16),
            "t": ("<f8", head - 8), "row": (("<f8", (len(self.columns),)), head),
        }  # fmt: skip
        end = head + 8 * len(self.columns)
        if self._begun is not None:
            fields["checksum"] = ("<u4", end)
            end += CHECKSUM_SIZE
        self.record = np.dtype(
            {
                "names": list(fields),
                "formats": [kind for kind, _ in fields.values()],
                "offsets": [offset for _, offset in fields.values()],
                "itemsize": end,
            }
        )
        self.room = max(self._size - self.start, 0) // end

    def pieces(self) -> "Iterator[NDArray[np.void]]":
        """Yield the rows, some thousand at a time, with the fields of `record`.

        Raises
        ------
        LogError
            The file cannot be read, or is damaged: a bit is another one, or a row is missing.
        """
        size = self.record.itemsize
        most = max(_AT_ONCE // size, 1) * size
        count = 0
        with self._opened() as stream:
            stream.seek(self.start)
            # No further than the file went when it was opened: a run may be adding to it.
            while content := stream.read(max(min(most, self._size - stream.tell()), 0)):
                if len(rows := self.rows_in(content, count)):
                    yield rows
                count += len(rows)
                if len(rows) * size < len(content):
                    break
            self._check_end(stream, self.start + count * size, count)

    def rows_in(self, content: bytes, before: int) -> "NDArray[np.void]":
        """Return the whole rows that some bytes of the file begin with.

        Parameters
        ----------
        content : bytes
            From the end of a row on.
        before : int
            How many rows stand before them.

        Raises
        ------
        LogError
            A row is damaged, or another one than it should be.
        """
        rows = np.frombuffer(content, self.record, len(content) // self.record.itemsize)
        rows = rows[: self._whole(rows)] if len(rows) else rows
        self._check(content, rows, before)
        return rows

    def raw_messages(self) -> Iterator[tuple[int, int, bytes]]:
        """Yield the log time (ns), the sequence number and the bytes of every message."""
        head = struct.calcsize("<BQHIQQ")
        for rows in self.pieces():
            content, size = rows.tobytes(), self.record.itemsize
            stamps, numbers = rows["stamp"].tolist(), rows["sequence"].tolist()
            for k, (stamp, number) in enumerate(zip(stamps, numbers, strict=True)):
                yield stamp, number, content[k * size + head : (k + 1) * size]

    def _opened(self) -> BinaryIO:
        try:
            return open_regular(self.path)
        except ConfigurationError as error:
            raise LogError(str(error).replace("read", "read the log", 1)) from error

    def _whole(self, rows: "NDArray[np.void]") -> int:
        """Return how many records there are up to the first that is no message."""
        whole = (
            (rows["opcode"] == OPCODE_MESSAGE)
            & (rows["length"] == self.record.itemsize - RECORD_PREFIX)
            & (rows["channel"] == CHANNEL_ID)
        )
        return len(rows) if whole.all() else int(np.argmin(whole))

    def _check(self, content: bytes, rows: "NDArray[np.void]", before: int) -> None:
        size = self.record.itemsize
        if self._begun is not None:
            view, begun, covered = memoryview(content), self._begun, size - CHECKSUM_SIZE
            for k, told in enumerate(rows["checksum"].tolist()):
                if zlib.crc32(view[k * size : k * size + covered], begun) != told:
                    raise self._damaged(before + k, "does not fit its checksum")
        expected = np.arange(before, before + len(rows), dtype=np.uint64) & 0xFFFFFFFF
        if (rows["sequence"] != expected).any():
            k = int(np.argmax(rows["sequence"] != expected))
            raise self._damaged(before + k, "has another number: rows are missing before it")

    def _check_end(self, stream: BinaryIO, end: int, count: int) -> None:
        """Judge what follows the last row: an index, or whatever a killed process left."""
        stream.seek(end)
        rest = stream.read(max(min(self.record.itemsize, self._size - end), 0))
        start = max(self._size - _FOOTER.size - len(MAGIC), end)
        stream.seek(start)
        tail = stream.read(max(self._size - start, 0))
        self.complete = tail.endswith(MAGIC)
        if rest[:1] == bytes([OPCODE_DATA_END]):
            if self.complete and len(tail) >= _FOOTER.size + len(MAGIC):
                summary = _FOOTER.unpack_from(tail[-_FOOTER.size - len(MAGIC) :])[2]
                if summary != end + _DATA_END_SIZE:
                    raise self._damaged(count, "is missing: the index stands elsewhere")
        elif self.complete or len(rest) == self.record.itemsize:
            raise self._damaged(count, "is no whole message")

    def _damaged(self, row: int, what: str) -> LogError:
        return LogError(f"the log {self.path} is damaged: row {row} of it {what}")


def read_log(path: str | Path) -> Log:
    """Read a log whole, also one that is being written or whose process was killed.

    Parameters
    ----------
    path : Path
        The ``log.mcap`` of a run folder.

    Raises
    ------
    LogError
        See `LogFile`.
    """
    return whole_log(LogFile(path))


def whole_log(file: LogFile) -> Log:
    """Read what is left of a log whole; LogError if it is damaged."""
    cycle, t = np.empty(file.room, np.uint64), np.empty(file.room)
    values, stamp = np.empty((file.room, len(file.columns))), np.empty(file.room, np.uint64)
    end = 0
    for rows in file.pieces():
        here = slice(end, end := end + len(rows))
        cycle[here], t[here], values[here] = rows["cycle"], rows["t"], rows["row"]
        stamp[here] = rows["stamp"]
    return Log(file.columns, cycle[:end], t[:end], values[:end], stamp[:end], file.complete)


def _read_preamble(path: Path, stream: BinaryIO) -> tuple[tuple[Column, ...], int, int | None]:
    """Return the columns, the offset of the first row, and what each checksum begins with."""
    magic = stream.read(len(MAGIC))
    if magic != MAGIC:
        kind = UnfinishedLog if MAGIC.startswith(magic) else LogError
        raise kind(f"{path} is not an MCAP file")
    offset = len(MAGIC)
    while len(head := stream.read(RECORD_PREFIX)) == RECORD_PREFIX:
        opcode, length = struct.unpack("<BQ", head)
        body = stream.read(min(length, _LONGEST_PREAMBLE))
        offset += RECORD_PREFIX + length
        if len(body) < length:
            break
        if opcode == _OPCODE_CHANNEL:
            try:
                channel = decode_channel(body)
            except ValueError as error:
                raise LogError(
                    f"the log {path} is damaged where its columns are described: {error}"
                ) from error
            if channel is None:
                raise LogError(f"{path} was not recorded by this program: it names no columns")
            columns, has_checksum = channel
            stream.seek(0)
            begun = zlib.crc32(stream.read(offset)) if has_checksum else None
            return columns, offset, begun
    raise UnfinishedLog(f"{path} ends before its columns are described")
