"""A path of the hand through given places: written in the experiment, or in a file.

The places are joined by a spline, on which the hand's nominal speed is constant. The law goes
through wrist and shoulder as on a line; see `look-ahead`.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from operator import add
from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Gt, Unit

from controllers.arm.geometry import SixAngles
from controllers.arm.kinematics import Dimensions
from controllers.arm.trajectory import ArmPath, Trajectory
from controllers.arm.types import Joints
from controllers.motion import InfeasibleMotion
from controllers.text_file import number_in, read_table

Length = Annotated[float, Unit("m")]
Place = tuple[Length, Length, Length]
Quaternion = tuple[float, float, float, float]

_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
_POSITION, _ROTATION = ("x", "y", "z"), ("qw", "qx", "qy", "qz")
_NEAR = (0.0, math.radians(20.0), math.radians(90.0), 0.0, math.radians(30.0), 0.0)


@dataclass(frozen=True, slots=True)
class PosePath(ArmPath):
    """A spline through places of the tool point, once from the first to the last.

    Parameters
    ----------
    file : str
        A CSV file: a header with ``x (mm), y (mm), z (mm)`` in any unit of length and, if the
        tool turns, the quaternion ``qw, qx, qy, qz`` of its rotation; a row for each place.
    points : tuple of tuple of float
        Instead of a file: places, m; the tool keeps its direction.
    frame : str
        ``base``: places and rotations are the base's. ``start``: they are seen from the hand as
        it is at `near`, in its tool's axes.
    near : tuple of float
        Joints near which the path begins, rad: they say which of the arm's branches it takes, and
        how the tool points if no rotation is given. Where a joint would leave its range that it
        keeps a whole turn away, the path begins there.
    speed : float
        Of the hand at most, m/s.
    """

    file: str = ""
    points: tuple[Place, ...] = ()
    frame: Literal["base", "start"] = "base"
    near: SixAngles = _NEAR
    speed: Annotated[float, Unit("m/s"), Gt(0)] = 0.1

    def __post_init__(self) -> None:
        if bool(self.file) == bool(self.points):
            raise ValueError("give a file or points, and not both.")

    def turned(self, turns: Joints) -> "PosePath":
        """Return the same path, begun with joints that are whole turns (rad) away."""
        q1, q2, q3, q4, q5, q6 = map(add, self.near, turns)
        return replace(self, near=(q1, q2, q3, q4, q5, q6))

    def trajectory(self, arm: Dimensions) -> Trajectory:
        """Return the path; see `ArmPath`.

        Raises
        ------
        InfeasibleMotion
            The file cannot be read, or there is no path through its places.
        """
        from controllers.arm.pose_trajectory import PoseTrajectory

        places, rotations = read_places(Path(self.file)) if self.file else (list(self.points), None)
        for number, (before, after) in enumerate(pairwise(places), 2):
            if before == after:
                raise InfeasibleMotion(f"place {number} of the path is place {number - 1} again.")
        if len(places) < 2:
            raise InfeasibleMotion(f"a path needs two places at least; there is {len(places)}.")
        return PoseTrajectory(
            arm, places, rotations, self.near, self.speed, from_start=self.frame == "start"
        )


def read_places(path: Path) -> tuple[list[Place], list[Quaternion] | None]:
    """Return the places (m) and, if there are any, the rotations of a CSV file.

    Raises
    ------
    InfeasibleMotion
        With the line and what is wrong with it.
    """
    rows = read_table(path)
    names = [name.strip().replace("(", " ").replace(")", "").split() for name in (rows or [[]])[0]]
    columns = {name[0]: k for k, name in enumerate(names) if name}
    missing = [name for name in _POSITION if name not in columns]
    turning = [name for name in _ROTATION if name in columns]
    if missing or (turning and len(turning) < len(_ROTATION)):
        raise InfeasibleMotion(
            f"{path}, line 1: the header has to name x, y and z with their units, and all of qw, "
            f"qx, qy, qz or none; it has {', '.join(columns) or 'nothing'}."
        )
    scales = [_scale(path, names[columns[name]]) for name in _POSITION]
    places, rotations = [], []
    for line, row in enumerate(rows[1:], 2):
        if not row:
            continue
        values = [_number(path, line, row, columns[name]) for name in (*_POSITION, *turning)]
        x, y, z = (scale * value for scale, value in zip(scales, values[:3], strict=True))
        places.append((x, y, z))
        if turning:
            w, i, j, k = values[3:]
            if abs(math.hypot(w, i, j, k) - 1.0) > 1e-2:
                raise InfeasibleMotion(
                    f"{path}, line {line}: the quaternion's length is "
                    f"{math.hypot(w, i, j, k):.4g} instead of 1."
                )
            rotations.append((w, i, j, k))
    return places, rotations if turning else None


def _scale(path: Path, name: list[str]) -> float:
    unit = name[1] if len(name) > 1 else ""
    if unit not in _UNITS:
        raise InfeasibleMotion(
            f"{path}, line 1: the unit of {name[0]} is {unit or 'missing'}; write {name[0]} (mm), "
            f"or one of {', '.join(_UNITS)}."
        )
    return _UNITS[unit]


def _number(path: Path, line: int, row: list[str], column: int) -> float:
    text = row[column] if column < len(row) else ""
    value = number_in(text)
    if not math.isfinite(value):
        raise InfeasibleMotion(f"{path}, line {line}: {text!r} is no number.")
    return value
