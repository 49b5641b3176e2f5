"""Places of the hand and how the tool stands there, out of a file."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from controllers.arm.places.columns import PoseColumns, Rotations, columns_of
from controllers.arm.places.table import TextRow, TextTable, read_cells
from controllers.arm.types import Vector
from controllers.motion import InfeasibleMotion

Quaternion = tuple[float, float, float, float]

_UNIT_WITHIN = 1e-2
"""By how much a quaternion's length may differ from 1."""
_SHORTEST = 1e-9
"""Length of a vector that still has a direction."""


class Poses(NamedTuple):
    """Places with what is known of the tool there; how it stands may be said in two ways or not.

    Parameters
    ----------
    places : list of tuple of float
        m.
    quaternions : list of tuple of float, optional
        The tool's rotation, w first.
    directions : list of tuple of float, optional
        Unit vectors along the tool.
    spins : list of float, optional
        How far the tool is turned about its direction, rad.
    source : str
        The file that says them; empty: none.
    lines : list of int
        Line of the file in which each place stands.
    """

    places: list[Vector]
    quaternions: list[Quaternion] | None = None
    directions: list[Vector] | None = None
    spins: list[float] | None = None
    source: str = ""
    lines: Sequence[int] = ()

    def where(self, number: int) -> str:
        """Return where a place stands, counted from 0, as the beginning of a sentence."""
        if not self.source:
            return f"place {number + 1} of the path"
        return f"{self.source}, line {self.lines[number]}: place {number + 1} of the path"

    def turns(self, number: int) -> bool:
        """Return whether the tool stands otherwise at a place than at the one before."""
        said = (self.quaternions, self.directions, self.spins)
        return any(of is not None and of[number] != of[number - 1] for of in said)


def read_poses(path: Path) -> Poses:
    """Return what a CSV or a YAML file says.

    The header names each column with its unit: ``x (mm), y (mm), z (mm)`` and, if the tool turns,
    one of

    - ``qw, qx, qy, qz``: a quaternion;
    - ``rotvec_x (deg), rotvec_y (deg), rotvec_z (deg)``: axis times angle;
    - ``euler-ZYX-1 (deg), euler-ZYX-2 (deg), euler-ZYX-3 (deg)``: angles about these axes in this
      order, in capitals about the turned axes, in small letters about the fixed ones;
    - ``tool_x, tool_y, tool_z`` and perhaps ``spin (deg)``: where the tool points, of any length.

    Raises
    ------
    InfeasibleMotion
        With file, line, column, value and bound.
    """
    table = read_cells(path)
    lines = [row.line for row in table.rows]
    return _poses(path, table)._replace(source=str(path), lines=lines)


def _poses(path: Path, table: TextTable) -> Poses:
    columns = columns_of(path, table.header)
    width = len(table.header.cells)
    for row in table.rows:
        if any(cell.text for cell in row.cells[width:]):  # as of a decimal comma
            raise InfeasibleMotion(
                f"{path}, line {row.line}: {len(row.cells)} cells under a header of {width}."
            )
    places = [_vector(path, row, columns) for row in table.rows]
    turning = [[column.value(path, row) for column in columns.turning] for row in table.rows]
    kind = columns.rotations
    if kind is Rotations.NONE:
        return Poses(places)
    if kind is Rotations.DIRECTION:
        pairs = zip(table.rows, turning, strict=True)
        spin = columns.spin
        spins = None if spin is None else [spin.value(path, row) for row in table.rows]
        return Poses(places, directions=[_direction(path, *pair) for pair in pairs], spins=spins)
    if kind is Rotations.QUATERNION:
        pairs = zip(table.rows, turning, strict=True)
        return Poses(places, [_quaternion(path, *pair) for pair in pairs])
    return Poses(places, _quaternions(columns, turning))


def _vector(path: Path, row: TextRow, columns: PoseColumns) -> Vector:
    x, y, z = (column.value(path, row) for column in columns.place)
    return x, y, z


def _quaternion(path: Path, row: TextRow, values: list[float]) -> Quaternion:
    w, x, y, z = values
    length = math.hypot(w, x, y, z)
    if abs(length - 1.0) > _UNIT_WITHIN:
        raise InfeasibleMotion(
            f"{path}, line {row.line}: the quaternion's length is {length:.4g} instead of 1."
        )
    return w, x, y, z


def _direction(path: Path, row: TextRow, values: list[float]) -> Vector:
    x, y, z = values
    length = math.hypot(x, y, z)
    if not _SHORTEST < length < math.inf:
        raise InfeasibleMotion(
            f"{path}, line {row.line}: ({x:g}, {y:g}, {z:g}) is no direction of the tool."
        )
    return x / length, y / length, z / length


def _quaternions(columns: PoseColumns, angles: list[list[float]]) -> list[Quaternion]:
    """Return the quaternions of rotation vectors or of Euler's angles, rad."""
    if not angles:
        return []
    from scipy.spatial.transform import Rotation as Turn  # a fifth of a second

    if columns.rotations is Rotations.VECTOR:
        turns = Turn.from_rotvec(angles)
    else:
        turns = Turn.from_euler(columns.sequence, angles)
    return [(w, x, y, z) for x, y, z, w in turns.as_quat().tolist()]
