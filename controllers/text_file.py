"""Text of a file that somebody else may have written: no pipe that waits, no endless device."""

import csv
import math
import os
import re
import stat
from pathlib import Path
from typing import Final

from controllers.motion import InfeasibleMotion

MOST: Final = 1 << 24
"""Bytes that a file of a motion may have."""
_LONGEST: Final = 10_000
"""Characters of a line of a table."""
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def read_lines(path: Path) -> list[str]:
    """Return the lines of a regular file in UTF-8.

    Raises
    ------
    InfeasibleMotion
        It cannot be read, is no regular file, or is longer than `MOST` bytes.
    """
    if path.is_symlink() and Path(os.path.realpath(path)).suffix != path.suffix:
        # Errors quote what is read: a link must not have them quote what is no such file.
        raise InfeasibleMotion(f"{path}: it is a link to a file of another kind.")
    try:
        # Looked at before it is opened: to open a device may already do something.
        if not stat.S_ISREG(path.stat().st_mode):
            raise InfeasibleMotion(f"{path}: it is not a regular file.")
        with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as stream:
            content = stream.read(MOST + 1)
        if len(content) > MOST:
            raise InfeasibleMotion(f"{path}: it has more than {MOST} bytes.")
        return content.decode("utf-8-sig").splitlines()
    except FileNotFoundError as error:
        raise InfeasibleMotion(f"{path}: there is no such file.") from error
    except OSError as error:
        raise InfeasibleMotion(f"{path}: the file cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InfeasibleMotion(
            f"{path}, line {line}: byte 0x{content[error.start]:02X} is not UTF-8 text."
        ) from error


def read_table_lines(path: Path) -> list[str]:
    """Return the lines of a table, as `read_lines`; none is longer than anybody writes.

    Raises
    ------
    InfeasibleMotion
        As `read_lines`, or a line is too long; with its number. Or semicolons stand between its
        cells, as spreadsheets write them where the comma is the decimal sign.
    """
    lines = read_lines(path)
    if lines and ";" in lines[0] and "," not in lines[0]:
        raise InfeasibleMotion(
            f"{path}, line 1: semicolons separate its cells; write commas between them, and a "
            f"decimal point in numbers."
        )
    for number, line in enumerate(lines, 1):
        if len(line) > _LONGEST:
            raise InfeasibleMotion(
                f"{path}, line {number}: it has more than {_LONGEST} characters."
            )
    return lines


def read_table(path: Path) -> list[tuple[int, list[str]]]:
    """Return the rows of a CSV file that count, the header first: their lines, and their cells.

    Empty lines do not count, nor those that begin with ``#``. Cells have no blanks around them.

    Raises
    ------
    InfeasibleMotion
        As `read_table_lines`, or a quotation does not end in its line.
    """
    rows = []
    for number, line in enumerate(read_table_lines(path), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            (cells,) = csv.reader([line], skipinitialspace=True, strict=True)
        except csv.Error as error:
            raise InfeasibleMotion(f"{path}, line {number}: {error}.") from error
        rows.append((number, [cell.strip() for cell in cells]))
    return rows


def number_in(cell: str) -> float:
    """Return a cell's number, NaN if it is none as tables have them: Python alone reads 1_000."""
    return float(cell) if _NUMBER.fullmatch(cell.strip()) else math.nan
