"""The seam between a camera and whoever looks on: one small file in the run's folder.

The camera makes it and leaves it alone; whoever looks on says so in it now and then. As long as
somebody does, the camera puts its newest picture there, in its own process and at a rate that an
eye follows. To find that nobody asks costs it one read of eight bytes a frame.

Nothing is mapped: a file that somebody shortens would kill who has mapped it.
"""

import contextlib
import math
import os
import stat
import struct
import zlib
from pathlib import Path
from time import monotonic
from typing import Final, NamedTuple

SUFFIX: Final = ".picture"
LARGEST: Final = 512 << 10
"""Bytes of a compressed picture at most."""
MOST_MARKS: Final = 16
_MAGIC: Final = b"rig picture 1\0\0\0"
_ASKED: Final = struct.Struct("<d")
_HEAD: Final = struct.Struct("<QII")
"""Number of the picture, length of what follows, its checksum."""
_FACTS: Final = struct.Struct("<QHHB23s")
_MARK: Final = struct.Struct("<ff")
_ASKED_AT, _HEAD_AT, _BODY_AT = 16, 24, 64
_ROOM: Final = _BODY_AT + _FACTS.size + MOST_MARKS * _MARK.size + LARGEST
_ASKED_FOR: Final = 2.0
"""For so long a picture is wanted after somebody has asked, s."""


class Snapshot(NamedTuple):
    """One frame of a camera, and what was found in it.

    Parameters
    ----------
    frame : int
        Its number in the stream.
    width, height : int
        Of the image in which the marks were found, pixels; the picture itself may be smaller.
    verdict : str
        A word or two: ``seen``, or why not; 23 bytes of it are kept.
    marks : tuple of tuple of float
        Where markers were found, (x, y) in pixels; the centre of the first one is (0, 0).
    jpeg : bytes
        The picture.
    """

    frame: int
    width: int
    height: int
    verdict: str
    marks: tuple[tuple[float, float], ...]
    jpeg: bytes


class PictureFile:
    """The file, open; for its owner alone.

    Parameters
    ----------
    path : Path
        The file.
    create : bool
        Make it; only the camera does.

    Raises
    ------
    OSError
        It is not there, or cannot be made.
    ValueError
        It is something else.
    """

    def __init__(self, path: Path, *, create: bool = False) -> None:
        flags = os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
        self._file = os.open(path, flags | (os.O_CREAT | os.O_EXCL if create else 0), 0o600)
        if create:
            os.pwrite(self._file, _MAGIC, 0)
        is_file = stat.S_ISREG(os.fstat(self._file).st_mode)
        if not is_file or os.pread(self._file, len(_MAGIC), 0) != _MAGIC:
            os.close(self._file)
            raise ValueError(f"{path} holds no picture")
        self._number = 0
        self._has_room = False

    # The camera's side ----------------------------------------------------------------

    def is_wanted(self) -> bool:
        """Return whether somebody has asked within the last two seconds."""
        told = os.pread(self._file, _ASKED.size, _ASKED_AT)
        if len(told) < _ASKED.size:
            return False  # nobody ever has
        return abs(monotonic() - float(_ASKED.unpack(told)[0])) < _ASKED_FOR

    def put(self, picture: Snapshot) -> None:
        """Put a picture there for whoever asks; one that is too large is left out."""
        marks = picture.marks[:MOST_MARKS]
        body = b"".join(
            (
                _FACTS.pack(
                    picture.frame,
                    picture.width,
                    picture.height,
                    len(marks),
                    picture.verdict.encode()[:23],
                ),
                *(_MARK.pack(*mark) for mark in marks),
                picture.jpeg,
            )
        )
        if len(picture.jpeg) > LARGEST:
            return
        self._number += 1
        head = _HEAD.pack(self._number, len(body), zlib.crc32(body))
        os.pwrite(self._file, head.ljust(_BODY_AT - _HEAD_AT, b"\0") + body, _HEAD_AT)

    # The side of who looks on ---------------------------------------------------------

    def ask(self) -> None:
        """Say that somebody looks on.

        Raises
        ------
        OSError
            There is no room for a picture.
        """
        if not self._has_room:  # taken by who looks on: the camera must not wait for it
            os.posix_fallocate(self._file, 0, _ROOM)
            self._has_room = True
        os.pwrite(self._file, _ASKED.pack(monotonic()), _ASKED_AT)

    def newest(self) -> Snapshot | None:
        """Return the picture if it is another than the last time; None: not, or it is not whole."""
        told = os.pread(self._file, _HEAD.size, _HEAD_AT)
        if len(told) < _HEAD.size:
            return None
        number, length, checksum = _HEAD.unpack(told)
        if number == self._number or not _FACTS.size <= length <= _ROOM - _BODY_AT:
            return None
        body = os.pread(self._file, length, _BODY_AT)
        if len(body) != length or zlib.crc32(body) != checksum:
            return None  # it is just being written
        self._number = number
        return _snapshot_of(body)

    def close(self) -> None:
        """Let go of it. Idempotent."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


def _snapshot_of(body: bytes) -> Snapshot | None:
    frame, width, height, count, verdict = _FACTS.unpack_from(body)
    end = _FACTS.size + count * _MARK.size
    if count > MOST_MARKS or len(body) < end:
        return None
    marks = tuple((x, y) for x, y in _MARK.iter_unpack(body[_FACTS.size : end]))
    if not all(math.isfinite(x) and math.isfinite(y) for x, y in marks):
        return None
    word = verdict.rstrip(b"\0").decode(errors="replace")
    return Snapshot(frame, width, height, word, marks, body[end:])


def forget_picture(path: Path | None) -> None:
    """Remove the file, if there is one: its run has ended."""
    if path is not None:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)
