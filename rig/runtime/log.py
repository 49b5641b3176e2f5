"""Read the log of a run, finished or not."""

import fcntl
import os
import struct
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.hal import RigError
from rig.hal.columns import Column
from rig.runtime.mcap_file import CHANNEL_ID, decode_columns
from rig.runtime.recorder import OPCODE_MESSAGE, RECORD_HEAD, RECORD_PREFIX

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MAGIC = b"\x89MCAP0\r\n"
_OPCODE_CHANNEL = 0x04


class LogError(RigError):
    """A file is not a log of this program."""


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
        known = ", ".join(column.name for column in self.columns)
        raise LogError(f"the log has no column {name!r}; it has {known}")

    def names(self, prefix: str) -> tuple[str, ...]:
        """Return the names of the columns that start with `prefix`, in order."""
        return tuple(c.name for c in self.columns if c.name.startswith(prefix))


def read_log(path: str | Path) -> Log:
    """Read a log, also one that is being written or whose process was killed.

    All messages have one length and stand side by side, so the file is one array; it ends at
    the first record that is not a whole message.

    Parameters
    ----------
    path : Path
        The ``log.mcap`` of a run folder.

    Raises
    ------
    LogError
        The file cannot be read, is not MCAP, or ends before its channel is described.
    """
    path = Path(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise LogError(f"cannot read the log {path}: {error.strerror or error}") from error
    columns, start = _read_preamble(path, content)
    head = struct.calcsize(RECORD_HEAD)
    record = np.dtype(
        {
            "names": ["opcode", "length", "channel", "stamp", "cycle", "t", "row"],
            "formats": ["u1", "<u8", "<u2", "<u8", "<u8", "<f8", ("<f8", (len(columns),))],
            "offsets": [0, 1, 9, 15, head - 16, head - 8, head],
            "itemsize": head + 8 * len(columns),
        }
    )
    rows = np.frombuffer(content, record, (len(content) - start) // record.itemsize, start)
    whole = (
        (rows["opcode"] == OPCODE_MESSAGE)
        & (rows["length"] == record.itemsize - RECORD_PREFIX)
        & (rows["channel"] == CHANNEL_ID)
    )
    if not whole.all():
        rows = rows[: int(np.argmin(whole))]
    return Log(
        columns=columns,
        cycle=rows["cycle"].copy(),
        t=rows["t"].copy(),
        values=rows["row"].copy(),
        stamp=rows["stamp"].copy(),
        complete=content.endswith(_MAGIC),
    )


def is_locked(path: str | Path) -> bool:
    """Return whether a living process holds the file (see `LogRecorder`); False if it is absent."""
    try:
        fd = os.open(path, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(fd, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(fd)
    return False


def _read_preamble(path: Path, content: bytes) -> tuple[tuple[Column, ...], int]:
    """Return the columns and the offset of the first record after the channel's."""
    if not content.startswith(_MAGIC):
        raise LogError(f"{path} is not an MCAP file")
    offset = len(_MAGIC)
    while offset + RECORD_PREFIX <= len(content):
        opcode, length = struct.unpack_from("<BQ", content, offset)
        offset += RECORD_PREFIX
        if offset + length > len(content):
            break
        if opcode == _OPCODE_CHANNEL:
            columns = decode_columns(content[offset : offset + length])
            if columns is None:
                raise LogError(f"{path} was not recorded by this program: it names no columns")
            return columns, offset + length
        offset += length
    raise LogError(f"{path} ends before its columns are described")
