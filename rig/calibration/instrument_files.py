"""Readings of instruments from files: a line for each, or a table of all that belong together."""

import csv
import difflib
import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from rig.calibration.instruments import Instrument, Readings, made_to
from rig.config.quantities import UnitError, parse_reading
from rig.hal import ConfigurationError
from rig.hal.files import read_regular

_MOST: Final = 1 << 22
"""Bytes: a reading is a line of some 40."""
_HEAD: Final = re.compile(r"(?P<name>.*?)\s*[(\[](?P<unit>[^)\]]+)[)\]]")
"""A column of a table: the quantity, and its unit in brackets."""


def read_file(instruments: Sequence[Instrument], path: Path) -> Readings:
    """Read what instruments showed.

    Either ``quantity,stretch,value`` lines, values with or without a unit; or a table that
    begins with ``stretch`` and the quantities with their units, as in ``stretch,hand x (mm),
    hand y (mm),hand z (mm)``. Lines that begin with # are remarks.

    Raises
    ------
    ConfigurationError
        It cannot be read, or something in it is no reading; with line and column.
    """
    readings = made_to(instruments)
    try:
        text = read_regular(path, _MOST).decode("utf-8-sig")
        rows = [
            (number, row)
            for number, row in enumerate(csv.reader(io.StringIO(text, newline="")), 1)
            if row and not row[0].startswith("#")
        ]
    except (OSError, UnicodeError, csv.Error) as error:
        raise ConfigurationError(f"cannot read the readings {path}: {error}") from error
    if rows and rows[0][1][0].strip() == "stretch":
        _read_table({i.name: i for i in instruments}, path, rows, readings)
    else:
        _read_lines({i.name: i for i in instruments}, path, rows, readings)
    return readings


def _read_lines(
    known: dict[str, Instrument],
    path: Path,
    rows: Sequence[tuple[int, list[str]]],
    readings: dict[str, dict[str, float]],
) -> None:
    for number, row in rows:
        if len(row) != 3 or row[0] not in known:
            raise ConfigurationError(
                f"{path}:{number}:1: expected quantity,stretch,value with one of "
                f"{', '.join(known)}; or a table that begins with stretch"
            )
        value = _value(path, number, row, 2, row[2], known[row[0]].unit)
        readings.setdefault(row[0], {})[row[1]] = value


def _read_table(
    known: dict[str, Instrument],
    path: Path,
    rows: Sequence[tuple[int, list[str]]],
    readings: dict[str, dict[str, float]],
) -> None:
    (line, head), *below = rows
    columns: list[tuple[Instrument, str]] = []
    for place, text in enumerate(head[1:], 1):
        found = _HEAD.fullmatch(text.strip())
        name, unit = (found["name"], found["unit"]) if found else (text.strip(), "")
        if name not in known:
            raise _Wrong(path, line, head, place, f"no quantity is called {name!r}", name, known)
        instrument = known[name]
        if unit:
            _value(path, line, head, place, f"1 {unit}", instrument.unit)
        columns.append((instrument, unit))
    for number, row in below:
        if len(row) != len(head):
            message = f"{len(row)} columns, the head has {len(head)}"
            raise _Wrong(path, number, row, min(len(row), len(head)) - 1, message)
        for place, (text, (instrument, unit)) in enumerate(zip(row[1:], columns, strict=True), 1):
            stretch = row[0].strip()
            if stretch not in instrument.stretches:
                message = f"no stretch is called {stretch!r}"
                raise _Wrong(path, number, row, 0, message, stretch, instrument.stretches)
            quantity = f"{text.strip()} {unit}" if unit else text
            value = _value(path, number, row, place, quantity, instrument.unit)
            readings.setdefault(instrument.name, {})[stretch] = value


def _value(path: Path, number: int, row: list[str], place: int, text: str, unit: str) -> float:
    try:
        return parse_reading(text, unit)
    except UnitError as error:
        raise _Wrong(path, number, row, place, str(error)) from error


class _Wrong(ConfigurationError):
    def __init__(
        self, path: Path, number: int, row: list[str], place: int, what: str,
        word: str = "", known: Sequence[str] | dict[str, Instrument] = (),
    ) -> None:  # fmt: skip
        column = 1 + sum(len(cell) + 1 for cell in row[:place])
        near = difflib.get_close_matches(word, list(known), n=1) if word else []
        hint = f"; did you mean {near[0]!r}?" if near else ""
        if known and not near:
            hint = f"; there are {', '.join(list(known)[:6])}{', …' if len(known) > 6 else ''}"
        super().__init__(f"{path}:{number}:{column}: {what}{hint}")
