"""One CAN frame as one line of text, as can-utils' ``candump -L`` writes it.

References
----------
can-utils, ``candump -L`` and ``log2asc``: ``(seconds) channel id#data``, the identifier with 3
hexadecimal digits, or 8 where it is extended or an error class; ``id#R`` is a remote frame.
"""

import re
from collections.abc import Iterable, Iterator
from typing import Final, TextIO

from drivers.can.frame import (
    ERROR_FLAG,
    EXTENDED_FLAG,
    EXTENDED_MASK,
    REMOTE_FLAG,
    STANDARD_MASK,
)
from rig.hal.frames import LoggedFrame

_LINE: Final = re.compile(
    r"\(\s*(\d{1,12}\.\d{1,12})\)\s+([\x21-\x7e]{1,64})\s+"  # time and channel
    r"([0-9A-F]{3}|[0-9A-F]{8})#(?:(R)\d?|((?:[0-9A-F]{2}\.?){0,8}))"  # frame
    r"(?:\s+([RT]))?\s*",  # direction, of newer candumps and of python-can
    re.IGNORECASE,
)
_LONGEST: Final = 1 << 16


def format_frame(can_id: int, data: bytes) -> str:
    """Return a frame as ``id#data``.

    Parameters
    ----------
    can_id : int
        With the flags of `drivers.can.frame`.
    data : bytes
        0 … 8 bytes.
    """
    if can_id <= STANDARD_MASK:  # nearly all
        return f"{can_id:03X}#{data.hex().upper()}"
    if can_id & ERROR_FLAG:
        name = f"{can_id & (EXTENDED_MASK | ERROR_FLAG):08X}"
    elif can_id & EXTENDED_FLAG:
        name = f"{can_id & EXTENDED_MASK:08X}"
    else:
        name = f"{can_id & STANDARD_MASK:03X}"
    return f"{name}#R" if can_id & REMOTE_FLAG else f"{name}#{data.hex().upper()}"


def parse_line(line: str) -> LoggedFrame:
    """Return the frame of a line.

    Raises
    ------
    ValueError
        It is not such a line, or its frame is none of classic CAN.
    """
    found = _LINE.fullmatch(line)
    if found is None:
        raise ValueError("this is no frame as candump -L writes it, (seconds) channel id#data")
    time, channel, name, remote, data, way = found.groups()
    can_id = int(name, 16)
    if len(name) == 8 and not can_id & ERROR_FLAG:
        can_id |= EXTENDED_FLAG
    elif len(name) == 3 and can_id > STANDARD_MASK:
        raise ValueError(f"0x{name} is no 11-bit identifier")
    if remote:
        can_id |= REMOTE_FLAG
    content = bytes.fromhex((data or "").replace(".", ""))
    is_sent = None if way is None else way.upper() == "T"
    return LoggedFrame(float(time), channel, can_id, content, is_sent)


def bounded(stream: TextIO, name: str) -> Iterator[str]:
    """Yield the lines of a text of somebody else, none of which fills the memory.

    Parameters
    ----------
    stream : TextIO
        The text.
    name : str
        What an error calls it.

    Raises
    ------
    ValueError
        A line is longer than any that holds a frame; with its number.
    """
    number = 0
    while line := stream.readline(_LONGEST):
        number += 1
        if len(line) == _LONGEST:
            raise ValueError(f"{name}:{number}: a line is longer than {_LONGEST} characters")
        yield line


def parse_lines(lines: Iterable[str], name: str) -> Iterator[LoggedFrame]:
    """Yield the frames of a log.

    The last line may be torn, where its writer was killed; it is left out.

    Parameters
    ----------
    lines : iterable of str
        With their ends.
    name : str
        What an error calls the log.

    Raises
    ------
    ValueError
        A line is none of a frame; with its number.
    """
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            yield parse_line(line)
        except ValueError as error:
            if not line.endswith("\n"):
                return
            raise ValueError(f"{name}:{number}: {error}") from error
