"""The columns that a file of places may have: names, units, bounds, and which belong together."""

import difflib
import math
import re
from enum import Enum
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from controllers.arm.places.table import TextCell, TextRow
from controllers.motion import InfeasibleMotion
from controllers.text_file import number_in

_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
_ANGLES = {"rad": 1.0, "deg": math.pi / 180.0, "mrad": 1e-3}
_FARTHEST = 100.0
"""Coordinate that no arm has, m."""
_MOST_TURNED = 1000.0
"""rad."""
_SEQUENCE = re.compile(r"euler-([xyz]{3}|[XYZ]{3})-[123]", re.ASCII)
_CLOSE = 0.75
"""How alike a column's name is to a known one that was meant, as `difflib` has it."""


class Rotations(tuple[str, ...], Enum):
    """Ways to say in a file how the tool stands; the values are the columns' names.

    They are tuples by type: of a plain member without names Python 3.11.2 forgets the value.
    """

    NONE = ()
    QUATERNION = ("qw", "qx", "qy", "qz")
    VECTOR = ("rotvec_x", "rotvec_y", "rotvec_z")
    EULER = ("euler-1", "euler-2", "euler-3")
    DIRECTION = ("tool_x", "tool_y", "tool_z")


PLACE = ("x", "y", "z")
SPIN = "spin"
_UNITLESS = (*Rotations.QUATERNION.value, *Rotations.DIRECTION.value)
_KNOWN = (
    *PLACE,
    *Rotations.QUATERNION.value,
    *Rotations.DIRECTION.value,
    SPIN,
    *Rotations.VECTOR.value,
    *(f"euler-ZYX-{k}" for k in (1, 2, 3)),
)


class PoseColumn(NamedTuple):
    """A column: where it is, what it is called, its unit and what that is in SI."""

    at: int
    name: str
    unit: str
    scale: float
    bound: float

    def value(self, path: Path, row: TextRow) -> float:
        """Return the number in a row, SI.

        Raises
        ------
        InfeasibleMotion
            There is none, or it is beyond its bound.
        """
        if self.at >= len(row.cells):
            raise InfeasibleMotion(
                f"{path}, line {row.line}: of its {len(row.cells)} cells none is {self.name}, "
                f"which is column {self.at + 1} of the header."
            )
        cell = row.cells[self.at]
        where = f"{path}, {cell.where} ({self.name})"
        number = number_in(cell.text)
        if not math.isfinite(number):
            raise InfeasibleMotion(f"{where}: {cell.text[:40]!r} is no number.")
        if abs(number * self.scale) > self.bound:
            bound = f"{self.bound / self.scale:.6g} {self.unit}".rstrip()
            raise InfeasibleMotion(
                f"{where}: {number:g} {self.unit}".rstrip() + f" is outside -{bound} … {bound}."
            )
        return number * self.scale


class PoseColumns(NamedTuple):
    """The columns of a file.

    Parameters
    ----------
    place : list of PoseColumn
        x, y, z.
    rotations : Rotations
        What the next ones mean.
    turning : list of PoseColumn
        In the order of `Rotations`.
    sequence : str
        Axes of Euler's angles, as scipy has them: capitals turn with the tool.
    spin : PoseColumn, optional
        About the tool's direction.
    """

    place: list[PoseColumn]
    rotations: Rotations
    turning: list[PoseColumn]
    sequence: str
    spin: PoseColumn | None


def columns_of(path: Path, header: TextRow) -> PoseColumns:
    """Return what a header says.

    A column whose name is nowhere near a known one counts for nothing: tables have numbers and
    remarks.

    Raises
    ------
    InfeasibleMotion
        With the place in the file, and what is missing there or too much.
    """
    found: dict[str, PoseColumn] = {}
    sequence = ""
    for at, cell in enumerate(header.cells):
        name, _, rest = cell.text.partition("(")
        name, unit = name.strip(), rest.strip().removesuffix(")").strip()
        if not rest and " " in name:  # `x mm`, as older files may have it
            name, _, unit = name.partition(" ")
            unit = unit.strip()
        of_euler = _SEQUENCE.fullmatch(name)
        if of_euler:
            sequence = _same_sequence(path, cell, of_euler[1], sequence)
            name = f"euler-{name[-1]}"
        elif name not in _KNOWN:
            _check_unknown(path, cell, name)
            continue
        if name in found:
            raise InfeasibleMotion(f"{path}, {cell.where}: {name} is there already.")
        found[name] = _column(path, cell, at, name, unit)
    return _grouped(path, header, found, sequence)


def _check_unknown(path: Path, cell: TextCell, name: str) -> None:
    """Raise if a name is so near to a known one that this was meant."""
    known = [*_KNOWN, *(shown.upper() for shown in _KNOWN)]
    near = difflib.get_close_matches(name, known, 1, _CLOSE)
    if near:
        meant = near[0] if near[0] in _KNOWN else near[0].lower()
        raise InfeasibleMotion(
            f"{path}, {cell.where}: no column is called {name[:40]!r}; did you mean {meant}?"
        )


def _same_sequence(path: Path, cell: TextCell, axes: str, before: str) -> str:
    """Return the axes of an Euler column, which are those of the others."""
    if before and axes != before:
        raise InfeasibleMotion(
            f"{path}, {cell.where}: the angles are about {before} in one column and about {axes} "
            f"in this one."
        )
    if any(a == b for a, b in pairwise(axes)):
        raise InfeasibleMotion(
            f"{path}, {cell.where}: {axes} turns about one axis twice on end, so that it does not "
            f"reach every rotation."
        )
    return axes


def _column(path: Path, cell: TextCell, at: int, name: str, unit: str) -> PoseColumn:
    if name in _UNITLESS:
        if unit not in ("", "1"):
            raise InfeasibleMotion(f"{path}, {cell.where}: {name} has no unit; it says {unit}.")
        return PoseColumn(at, name, "", 1.0, math.inf)
    units = _LENGTHS if name in PLACE else _ANGLES
    if unit not in units:
        usual = "mm" if name in PLACE else "deg"
        raise InfeasibleMotion(
            f"{path}, {cell.where}: the unit of {name} is {unit[:40] or 'missing'}; write {name} "
            f"({usual}), or one of {', '.join(units)}."
        )
    return PoseColumn(at, name, unit, units[unit], _FARTHEST if name in PLACE else _MOST_TURNED)


def _grouped(
    path: Path, header: TextRow, found: dict[str, PoseColumn], sequence: str
) -> PoseColumns:
    where = f"{path}, line {header.line}: the header"
    begun = [kind for kind in Rotations if any(name in found for name in kind.value)]
    if len(begun) > 1:
        raise InfeasibleMotion(
            f"{where} says how the tool stands in two ways, {begun[0].value[0]} … and "
            f"{begun[1].value[0]} …; leave one out."
        )
    kind = begun[0] if begun else Rotations.NONE
    if any(name not in found for name in (*PLACE, *kind.value)):
        raise InfeasibleMotion(
            f"{where} has to name x, y and z with their units, and all of "
            f"{', '.join(kind.value or Rotations.QUATERNION.value)} or none; it has "
            f"{', '.join(found) or 'nothing'}."
        )
    if SPIN in found and kind is not Rotations.DIRECTION:
        raise InfeasibleMotion(
            f"{where} has a spin, which is about the tool's direction: it needs tool_x, tool_y, "
            f"tool_z."
        )
    place, turning = ([found[name] for name in names] for names in (PLACE, kind.value))
    return PoseColumns(place, kind, turning, sequence, found.get(SPIN))
