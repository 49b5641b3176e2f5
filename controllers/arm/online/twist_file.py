"""Twists in a CSV file: from when on, and how the hand is to move then."""

import math
from pathlib import Path
from typing import Annotated

from annotated_types import Unit

from controllers.motion import InfeasibleMotion
from controllers.text_file import number_in, read_table

Time = Annotated[float, Unit("s")]
Speed = Annotated[float, Unit("m/s")]
TurnRate = Annotated[float, Unit("rad/s")]
Row = tuple[Time, Speed, Speed, Speed, TurnRate, TurnRate, TurnRate]
"""From when on, s, and the twist, m/s and rad/s."""

_TIMES = {"s": 1.0, "ms": 1e-3}
_SPEEDS = {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3}
_TURNS = {"rad/s": 1.0, "deg/s": math.pi / 180.0}
_LINEAR, _ANGULAR = ("vx", "vy", "vz"), ("wx", "wy", "wz")
_UNITS = {"t": _TIMES, **dict.fromkeys(_LINEAR, _SPEEDS), **dict.fromkeys(_ANGULAR, _TURNS)}


def read_rows(path: Path) -> list[tuple[int, Row]]:
    """Return the rows of a CSV file, in SI, with the line of each.

    Raises
    ------
    InfeasibleMotion
        With the line and what is wrong with it.
    """
    lines = read_table(path)
    if not lines:
        raise InfeasibleMotion(f"{path}: the file is empty; its header begins with t (s).")
    names = _columns(f"{path}, line {lines[0][0]}", lines[0][1])
    rows: list[tuple[int, Row]] = []
    for number, cells in lines[1:]:
        if len(cells) != len(names):
            raise InfeasibleMotion(
                f"{path}, line {number}: {len(cells)} values, the header has {len(names)}."
            )
        told = {
            name: scale * _number(path, number, text)
            for (name, scale), text in zip(names, cells, strict=True)
        }
        t, vx, vy, vz, wx, wy, wz = (told.get(name, 0.0) for name in _UNITS)
        rows.append((number, (t, vx, vy, vz, wx, wy, wz)))
    return rows


def _columns(where: str, header: list[str]) -> list[tuple[str, float]]:
    """Return each column's name, and by what its values are multiplied."""
    found: list[tuple[str, float]] = []
    for text in header:
        name, _, unit = text.replace("(", " ").replace(")", " ").strip().partition(" ")
        if name not in _UNITS or name in dict(found):
            raise InfeasibleMotion(
                f"{where}: the column {text.strip()!r} is "
                f"{'there twice' if name in _UNITS else 'unknown'}; columns are "
                f"{', '.join(_UNITS)}, each once."
            )
        units = _UNITS[name]
        if unit.strip() not in units:
            raise InfeasibleMotion(
                f"{where}: the unit of {name} is {unit.strip() or 'missing'}; write "
                f"{name} ({next(iter(units))}), or one of {', '.join(units)}."
            )
        found.append((name, units[unit.strip()]))
    names = dict(found)
    turning = [name for name in _ANGULAR if name in names]
    if not all(name in names for name in ("t", *_LINEAR)) or 0 < len(turning) < len(_ANGULAR):
        raise InfeasibleMotion(
            f"{where}: the header has to name t, vx, vy and vz, and all of wx, wy, wz or "
            f"none; it has {', '.join(names) or 'nothing'}."
        )
    return found


def _number(path: Path, line: int, text: str) -> float:
    value = number_in(text)
    if not math.isfinite(value):
        raise InfeasibleMotion(f"{path}, line {line}: {text!r} is no number.")
    return value
