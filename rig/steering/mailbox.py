"""A page of memory that two processes share: one writes, the loop reads.

To look into it takes the loop no system call, and so nothing that could block. The writer's bytes
may arrive in any order: what is in the box counts only if its checksum fits. The memory is of the
loop's process and sealed: were it a file, whoever shortens it would kill who looks into it. The
run's folder only says where it is.
"""

import fcntl
import mmap
import os
import stat
import struct
import zlib
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

BOX = "steering.box"
_SIZE = 4096
_SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
_LONGEST_ADDRESS = 64
_MAGIC = b"rig gain 1\0\0\0\0\0\0"
_COUNT = struct.Struct("<Q")
_BODY = struct.Struct("<QIddI")
"""Number of the wish, index of the gain, value, duration of its ramp (s), checksum."""
_BEAT_AT, _BODY_AT = 16, 24


class Wish(NamedTuple):
    """A gain that somebody wants changed.

    Parameters
    ----------
    number : int
        Grows from one to the next.
    gain : int
        Index of the gain among those that the law lets be changed.
    value : float
        In the unit of the setting.
    ramp : float
        In which it is to be reached, s.
    """

    number: int
    gain: int
    value: float
    ramp: float


class Mailbox:
    """The memory, mapped; for its owner alone.

    Parameters
    ----------
    run : Path
        The run's folder.
    create : bool
        Make it; only the loop's process does.

    Raises
    ------
    OSError
        It is not there, or cannot be made.
    ValueError
        It is something else.
    """

    def __init__(self, run: Path, *, create: bool = False) -> None:
        self._descriptor: int | None = None
        if create:
            self._map = self._make(run / BOX)
            return
        descriptor = os.open(_place_of(run / BOX), os.O_RDWR | os.O_NONBLOCK)
        try:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise ValueError(f"{run / BOX} leads to no mailbox")
            self._map = mmap.mmap(descriptor, _SIZE)
        finally:
            os.close(descriptor)
        if self._map[: len(_MAGIC)] != _MAGIC:
            raise ValueError(f"{run / BOX} leads to no mailbox")

    def _make(self, path: Path) -> mmap.mmap:
        """Return new memory, once the folder says where it is."""
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW
        address = os.open(path, flags, 0o600)
        try:
            self._descriptor = memory = os.memfd_create(BOX, os.MFD_ALLOW_SEALING | os.MFD_CLOEXEC)
            os.write(memory, _MAGIC.ljust(_SIZE, b"\0"))
            fcntl.fcntl(memory, fcntl.F_ADD_SEALS, _SEALS)
            os.write(address, f"{os.getpid()} {memory}\n".encode())
        finally:
            os.close(address)
        return mmap.mmap(memory, _SIZE)

    def beats(self) -> int:
        """Return how often somebody has said that he holds on."""
        (count,) = _COUNT.unpack_from(self._map, _BEAT_AT)
        return int(count)

    def newest(self) -> int:
        """Return the number of the wish that is in the box, or is just being put there."""
        (number,) = _COUNT.unpack_from(self._map, _BODY_AT)
        return int(number)

    def read(self) -> Wish | None:
        """Return the wish in the box; None while it is not whole."""
        content = self._map[_BODY_AT : _BODY_AT + _BODY.size]
        *told, checksum = _BODY.unpack(content)
        if zlib.crc32(content[:-4]) != checksum:
            return None
        number, gain, value, ramp = told
        return Wish(number, gain, value, ramp)

    def post(self, gain: int, value: float, ramp: float) -> int:
        """Put a wish into the box; return its number."""
        number = self.newest() + 1
        content = _BODY.pack(number, gain, value, ramp, 0)
        self._map[_BODY_AT : _BODY_AT + _BODY.size] = content[:-4] + struct.pack(
            "<I", zlib.crc32(content[:-4])
        )
        return number

    def beat(self) -> None:
        """Say that somebody holds on."""
        _COUNT.pack_into(self._map, _BEAT_AT, self.beats() + 1)

    def close(self) -> None:
        """Let go of the memory. Idempotent."""
        self._map.close()
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def __enter__(self) -> "Mailbox":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _place_of(path: Path) -> str:
    """Return where the memory is, as its process is asked for it."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        words = os.read(descriptor, _LONGEST_ADDRESS).split()
    finally:
        os.close(descriptor)
    if len(words) != 2 or not all(word.isdigit() for word in words):
        raise ValueError(f"{path} leads to no mailbox")
    process, number = words
    return f"/proc/{process.decode()}/fd/{number.decode()}"
