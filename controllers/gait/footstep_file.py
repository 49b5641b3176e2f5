"""Footprints from a CSV file, read strictly."""

import difflib
import math
from pathlib import Path
from typing import NamedTuple

from controllers.gait.footprints import MOST_STEPS, Footstep
from controllers.motion import InfeasibleMotion
from controllers.text_file import number_in, read_table

_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_ANGLES = {"rad": 1.0, "deg": math.pi / 180.0, "mrad": 1e-3}
_TIMES = {"s": 1.0, "ms": 1e-3}


class _Quantity(NamedTuple):
    """A column's units, with its bounds in the first of them."""

    units: dict[str, float]
    low: float
    high: float
    optional: bool = False


_COLUMNS = {
    "x": _Quantity(_LENGTHS, -100.0, 100.0),
    "y": _Quantity(_LENGTHS, -100.0, 100.0),
    "heading": _Quantity(_ANGLES, -100.0, 100.0),
    "height": _Quantity(_LENGTHS, -10.0, 10.0),
    "pitch": _Quantity(_ANGLES, -0.5, 0.5),
    "roll": _Quantity(_ANGLES, -0.5, 0.5),
    "lift": _Quantity(_LENGTHS, 1e-4, 0.3, True),
    "shift": _Quantity(_TIMES, 1e-3, 600.0, True),
    "swing": _Quantity(_TIMES, 1e-3, 600.0, True),
}
_FOOT, _NEEDED = "foot", ("foot", "x", "y")


class _Column(NamedTuple):
    name: str
    unit: str
    scale: float


def read_footsteps(path: Path) -> tuple[Footstep, ...]:
    """Return the footprints of a CSV file.

    The header names each column with its unit: ``foot, x (mm), y (mm)`` and, where they matter,
    ``heading (deg), height (mm), pitch (deg), roll (deg), lift (mm), shift (s), swing (s)``, in any
    order. A row is one footprint. A cell of the last three may be empty: then that step is as all
    others. Lines that begin with ``#`` and empty ones count for nothing.

    Parameters
    ----------
    path : Path
        Of the file.

    Raises
    ------
    InfeasibleMotion
        With file, line, column, and what is wrong there.
    """
    numbered = read_table(path)
    if not numbered:
        raise InfeasibleMotion(f"{path}: the file is empty; its header begins with foot, x (mm).")
    columns = _header(path, *numbered[0])
    steps = [_footstep(path, line, row, columns) for line, row in numbered[1:]]
    if not 1 <= len(steps) <= MOST_STEPS:
        raise InfeasibleMotion(f"{path}: {len(steps)} footprints; there may be 1 to {MOST_STEPS}.")
    return tuple(steps)


def lines_of_steps(path: Path) -> tuple[int, ...]:
    """Return the line of a file that each footprint stands in."""
    return tuple([line for line, _ in read_table(path)[1:]])


def _header(path: Path, line: int, row: list[str]) -> list[_Column]:
    columns = []
    for number, cell in enumerate(row, 1):
        where = f"{path}, line {line}, column {number}"
        name, _, rest = cell.partition("(")
        name, unit = name.strip(), rest.removesuffix(")").strip()
        if name == _FOOT and not unit:
            columns.append(_Column(name, "", 1.0))
        elif name not in _COLUMNS:
            near = difflib.get_close_matches(name, [_FOOT, *_COLUMNS], 1)
            hint = f"did you mean {near[0]}?" if near else f"known are foot, {', '.join(_COLUMNS)}."
            raise InfeasibleMotion(f"{where}: no column is called {cell!r}; {hint}")
        elif unit not in _COLUMNS[name].units:
            known = ", ".join(_COLUMNS[name].units)
            raise InfeasibleMotion(
                f"{where}: {name} has {f'the unit {unit!r}' if unit else 'no unit'}; write it as "
                f"{name} ({next(iter(_COLUMNS[name].units))}), with one of {known}."
            )
        else:
            columns.append(_Column(name, unit, _COLUMNS[name].units[unit]))
        if columns[-1].name in [column.name for column in columns[:-1]]:
            raise InfeasibleMotion(f"{where}: {name} is there already.")
    missing = [name for name in _NEEDED if name not in [column.name for column in columns]]
    if missing:
        raise InfeasibleMotion(
            f"{path}, line {line}: the header has no {' and no '.join(missing)}; it has "
            f"{', '.join(row)}."
        )
    return columns


def _footstep(path: Path, line: int, row: list[str], columns: list[_Column]) -> Footstep:
    if len(row) != len(columns):
        raise InfeasibleMotion(
            f"{path}, line {line}: {len(row)} cells under a header of {len(columns)}."
        )
    values: dict[str, float | None] = {}
    foot = ""
    for column, cell in zip(columns, row, strict=True):
        where = f"{path}, line {line}, {column.name}"
        if column.name == _FOOT:
            foot = cell
            if foot not in ("right", "left"):
                raise InfeasibleMotion(f"{where}: {cell!r} is neither right nor left.")
            continue
        values[column.name] = _value(where, cell, column)
    return Footstep("right" if foot == "right" else "left", **values)  # type: ignore[arg-type]


def _value(where: str, cell: str, column: _Column) -> float | None:
    """Return a cell's number in SI units; None if it is empty and may be."""
    quantity = _COLUMNS[column.name]
    if not cell and quantity.optional:
        return None
    number = number_in(cell)
    if math.isnan(number):
        raise InfeasibleMotion(f"{where}: {cell!r} is no number.")
    value = number * column.scale
    if not quantity.low <= value <= quantity.high:
        raise InfeasibleMotion(
            f"{where}: {number:g} {column.unit} is outside {quantity.low / column.scale:.4g} … "
            f"{quantity.high / column.scale:.4g} {column.unit}."
        )
    return value
