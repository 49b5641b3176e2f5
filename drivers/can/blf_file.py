"""What a BLF file of somebody else has to keep to before python-can reads it.

Its reader inflates a container whole, whatever comes of it, and stands still at an object that says
no size. Both are looked for here, a container at a time.

References
----------
Vector, "BLF logging": a file header, then objects, ``LOBJ``; an object of type 10 is a container of
objects, of which one may go on in the next container.
"""

import struct
import zlib
from typing import BinaryIO, Final

_FILE: Final = struct.Struct("<4sL")
_OBJECT: Final = struct.Struct("<4sHHLL")
_CONTAINER: Final = struct.Struct("<H6xL4x")
_IS_CONTAINER: Final = 10
_DEFLATED: Final = 2
_MOST: Final = 1 << 24
"""Bytes of an object, and of what a container holds; the tools write some 128 KiB."""
_SWELLS: Final = 200
"""What a container holds is at most so many times as long as it is, beyond `_SMALL` bytes."""
_SMALL: Final = 1 << 17


def check_blf(stream: BinaryIO) -> None:
    """Look through a file from its beginning; what is no BLF at all is left for the reader.

    Raises
    ------
    ValueError
        A container holds too much, or an object has no size or too large a one.
    """
    header = stream.read(_FILE.size)
    if len(header) < _FILE.size:
        return
    signature, size = _FILE.unpack(header)
    if signature != b"LOGG" or not _FILE.size <= size <= _MOST:
        raise ValueError("it has no header")
    stream.seek(size)
    rest = b""
    while len(base := stream.read(_OBJECT.size)) == _OBJECT.size:
        signature, _, _, size, kind = _OBJECT.unpack(base)
        if signature != b"LOBJ":
            return
        _check_size(size)
        content = stream.read(size - _OBJECT.size)
        stream.read(size % 4)
        if kind == _IS_CONTAINER:
            rest = _rest_of(rest + _inflated(content))


def _check_size(size: int) -> None:
    if not _OBJECT.size <= size <= _MOST:
        raise ValueError(f"an object of it says that it has {size} bytes")


def _inflated(content: bytes) -> bytes:
    """Return what a container holds."""
    if len(content) < _CONTAINER.size:
        return b""
    method, _ = _CONTAINER.unpack_from(content)
    held = content[_CONTAINER.size :]
    if method != _DEFLATED:
        return held
    most = min(_MOST, _SMALL + _SWELLS * len(held))
    try:
        inflated = zlib.decompressobj().decompress(held, most + 1)
    except zlib.error as error:
        raise ValueError(f"a container of it cannot be read ({error})") from error
    if len(inflated) > most:
        raise ValueError(f"a container of {len(held)} bytes swells to more than {most}")
    return inflated


def _rest_of(held: bytes) -> bytes:
    """Return the object at the end of a container that goes on in the next one."""
    place = 0
    while (found := held.find(b"LOBJ", place, place + 8)) >= 0:
        if found + _OBJECT.size > len(held):
            return held[place:]
        size = _OBJECT.unpack_from(held, found)[3]
        _check_size(size)
        if found + size > len(held):
            return held[place:]
        place = found + size
    return held[place:]
