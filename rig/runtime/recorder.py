"""The log of a run: one MCAP message per cycle, in the kernel before the next cycle starts."""

import contextlib
import fcntl
import os
import struct
import time
import zlib
from collections.abc import Sequence
from operator import itemgetter
from pathlib import Path

from rig.hal import RigError
from rig.hal.columns import Column, group_order
from rig.runtime.mcap_file import CHANNEL_ID, encode_ending, encode_preamble

RECORD_HEAD = "<BQHIQQ4siIQd"
"""Everything of a Message record before the row: opcode, length, channel, sequence, log time,
publish time; then the CDR header, stamp (s, ns), cycle and rig time. All eight-byte fields of
the CDR body fall on multiples of eight from its start, so CDR needs no padding."""
RECORD_PREFIX = 9
"""Bytes of opcode and length, which the length does not count."""
OPCODE_MESSAGE = 0x05

CHECKSUM_SIZE = 4
"""Bytes of the CRC-32 at a record's end. It covers the record and, as the value that it begins
with, everything before the first one: a flipped bit of a name or a unit is seen as well."""

_put_checksum = struct.Struct("<I").pack_into
_CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
_NANO = 1_000_000_000


class RecorderError(RigError):
    """The log cannot be written.

    Parameters
    ----------
    path : Path
        The log.
    error : OSError
        What the system said.
    """

    def __init__(self, path: Path, error: OSError) -> None:
        self.path = path
        self.error = error
        super().__init__(f"cannot write the log {path}: {error.strerror or error}")


class LogRecorder:
    """Writes one row per cycle to an MCAP file with ROS 2 CDR messages.

    When `write` has returned, the row is the kernel's: killing the process (SIGKILL too) loses
    nothing. The file is not synced, so a power cut may lose the last seconds. It is unchunked,
    because a chunk lives in the process until it is full. While the file is open it is locked
    (flock), so a reader can tell a run that goes on from one that was killed.

    Parameters
    ----------
    path : Path
        A file that does not exist yet.
    columns : sequence of Column
        What a row holds. Columns of one group need not stand together in the row; they do in
        the message, and so in `LogRecorder.columns`.
    wall_clock_ns : int, optional
        Wall-clock time of the first row, ns since the epoch; default: when it is written.

    Raises
    ------
    RecorderError
        The file cannot be created.
    ValueError
        The columns do not make a legal message.

    References
    ----------
    .. [1] MCAP specification, https://mcap.dev/spec
    .. [2] OMG, *DDS-XTypes*, section 7.4: the CDR encapsulation.
    """

    def __init__(
        self, path: str | Path, columns: Sequence[Column], wall_clock_ns: int | None = None
    ) -> None:
        self.path = Path(path)
        order = group_order(columns)
        self.columns = tuple(columns[index] for index in order)
        self._arrange = None if order == tuple(range(len(order))) else itemgetter(*order)
        self._width = len(order)
        self.count = 0
        self._record = struct.Struct(f"{RECORD_HEAD}{len(self.columns)}d")
        self._pack_into = self._record.pack_into
        self._size = self._record.size + CHECKSUM_SIZE
        self._body = self._size - RECORD_PREFIX
        self._buffer = bytearray(self._size)
        self._checked = memoryview(self._buffer)[: self._record.size]
        self._wall_clock_ns = wall_clock_ns
        self._epoch: int | None = None
        self._first_stamp = self._last_stamp = 0
        self._failed: RecorderError | None = None
        preamble = encode_preamble(self.columns)
        self._begun = zlib.crc32(preamble)
        try:
            self._fd = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
        except OSError as error:
            raise RecorderError(self.path, error) from error
        # Some network file systems have no locks: recording matters more than telling later
        # whether the process still lives.
        with contextlib.suppress(OSError):
            fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        self._data_start = len(preamble)
        try:
            self._write_all(preamble)
        except OSError as error:
            os.close(self._fd)
            self._fd = -1
            raise RecorderError(self.path, error) from error

    def write(self, cycle: int, t: float, row: Sequence[float]) -> None:
        """Record one cycle; the kernel has it when this returns.

        Parameters
        ----------
        cycle : int
            Number of the cycle.
        t : float
            Time on the rig's clock, s.
        row : sequence of float
            One number per column, SI.

        Raises
        ------
        RecorderError
            The disk is full or the file cannot be written; every later call says so too.
        ValueError
            The row has another length than the columns.
        """
        if self._failed is not None:
            raise self._failed
        if len(row) != self._width:
            raise ValueError(f"a row of {len(row)} numbers for {self._width} columns")
        if self._arrange is not None:
            row = self._arrange(row)
        epoch = self._epoch
        if epoch is None:
            epoch = self._start(t)
        stamp = epoch + int(t * 1e9 + 0.5)
        seconds, nanoseconds = divmod(stamp, _NANO)
        # The whole record is packed here in one go: mcap's Writer.add_message builds it field
        # by field, which takes three times as long and more than one write.
        data = self._buffer
        self._pack_into(
            data, 0,
            OPCODE_MESSAGE, self._body, CHANNEL_ID, self.count & 0xFFFFFFFF, stamp, stamp,
            _CDR_LITTLE_ENDIAN, seconds, nanoseconds, cycle, t, *row,
        )  # fmt: skip
        _put_checksum(data, self._record.size, zlib.crc32(self._checked, self._begun))
        try:
            if os.write(self._fd, data) != len(data):
                self._complete(data)
        except OSError as error:
            self._failed = RecorderError(self.path, error)
            raise self._failed from error
        self.count += 1
        self._last_stamp = stamp

    def close(self) -> None:
        """Write the index that readers look for and release the file. Idempotent.

        A log without its index is still a good log, so an error here is not raised: the file
        is cut back to its last whole message.
        """
        if self._fd < 0:
            return
        end = self._data_start + self.count * self._size
        try:
            # Whatever a failed write left behind would make the index unreadable.
            os.ftruncate(self._fd, end)
            os.lseek(self._fd, end, os.SEEK_SET)
            self._write_all(
                encode_ending(self.columns, end, self.count, self._first_stamp, self._last_stamp)
            )
        except OSError:
            with contextlib.suppress(OSError):
                os.ftruncate(self._fd, end)
        finally:
            os.close(self._fd)
            self._fd = -1

    def __enter__(self) -> "LogRecorder":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _start(self, t: float) -> int:
        wall_clock = time.time_ns() if self._wall_clock_ns is None else self._wall_clock_ns
        self._epoch = wall_clock - int(t * 1e9 + 0.5)
        self._first_stamp = wall_clock
        return self._epoch

    def _complete(self, data: bytearray) -> None:
        """Write what a short write has left over."""
        end = self._data_start + self.count * self._size
        done = os.lseek(self._fd, 0, os.SEEK_CUR) - end
        self._write_all(data[done:])

    def _write_all(self, data: bytes | bytearray) -> None:
        view = memoryview(data)
        while view:
            view = view[os.write(self._fd, view) :]
