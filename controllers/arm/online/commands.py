"""Twists that an experiment asks an arm for: written in it, in a file, or from outside."""

import math
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal, Protocol

from annotated_types import Gt, Interval, Unit

from controllers.arm.geometry import SixAngles
from controllers.arm.on_direction.numbers import Six
from controllers.motion import InfeasibleMotion
from controllers.text_file import number_in, read_table

Time = Annotated[float, Unit("s")]
Speed = Annotated[float, Unit("m/s")]
TurnRate = Annotated[float, Unit("rad/s")]
Row = tuple[Time, Speed, Speed, Speed, TurnRate, TurnRate, TurnRate]
"""From when on, s, and the twist, m/s and rad/s."""
Silence = Annotated[float, Unit("s"), Interval(gt=0, le=0.1)]

FASTEST = 1000.0
"""m/s or rad/s: what is more is a mistake, and squared no number."""
_TIMES = {"s": 1.0, "ms": 1e-3}
_SPEEDS = {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3}
_TURNS = {"rad/s": 1.0, "deg/s": math.pi / 180.0}
_LINEAR, _ANGULAR = ("vx", "vy", "vz"), ("wx", "wy", "wz")
_UNITS = {"t": _TIMES, **dict.fromkeys(_LINEAR, _SPEEDS), **dict.fromkeys(_ANGULAR, _TURNS)}
_START = tuple(math.radians(angle) for angle in (0.0, 20.0, 90.0, 0.0, 30.0, 0.0))


class Heard(Protocol):
    """Whoever asks for twists while the arm moves."""

    def twist(self, t: float) -> Sequence[float] | None:
        """Return what is asked for; see `ArmTwists.twist`."""

    def leave(self) -> None:
        """Hear no more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmTwists(ABC):
    """Base of what asks an arm for twists while it moves; another package's references inherit it.

    Parameters
    ----------
    start : tuple of float
        Joints to start from, rad.
    frame : str
        Whose axes twists are given in: ``base``, or ``tool``. They are of the tool point.
    boundary : str
        ``stay``: a hand that is asked to leave the workspace stands at its boundary. ``back``: it
        comes back on the same line with the elbow on its other side, as in Miyata et al.
    silence : float
        Who has not been heard for so long is waited for no longer, s: the hand brakes. Heard
        within 0.1 s, it goes on; later only after a twist of zero.
    rest : float
        After the last word the hand is at rest within this time, s: joints go no faster than
        they can brake from in what `silence` leaves of it. Twists that are known beforehand,
        those of a file, go at the joints' whole rates.
    duration : float
        How long is listened, s.
    """

    start: SixAngles = _START  # type: ignore[assignment]
    frame: Literal["base", "tool"] = "base"
    boundary: Literal["stay", "back"] = "stay"
    silence: Silence = 0.02
    rest: Annotated[float, Unit("s"), Interval(gt=0, le=10)] = 0.1
    duration: Annotated[float, Unit("s"), Gt(0)] = 60.0

    @property
    def real_time(self) -> bool:
        """Whether somebody asks who lives in real time, which a simulation then keeps to."""
        return False

    @abstractmethod
    def twist(self, t: float) -> Sequence[float] | None:
        """Return what is asked for: velocity (m/s) and angular velocity (rad/s), six numbers.

        Called once in every cycle; it must not wait. None: nothing new has been heard.

        Parameters
        ----------
        t : float
            Since the motion began, s.
        """

    def listen(self) -> "Heard":
        """Begin to hear, before the rig moves; return what is asked in every cycle."""
        return self

    def leave(self) -> None:
        """Hear no more."""
        return

    def known(self) -> list[Row] | None:
        """Return all that will be asked for, if that is known beforehand.

        Raises
        ------
        InfeasibleMotion
            It cannot be read.
        """
        return None


@dataclass(frozen=True, slots=True, kw_only=True)
class TwistRows(ArmTwists):
    """Twists with the instants from which on they are asked for.

    Parameters
    ----------
    file : Path, optional
        A CSV file. Its header names ``t (s), vx (mm/s), vy (mm/s), vz (mm/s)`` and, if the tool
        turns, ``wx (deg/s), wy (deg/s), wz (deg/s)``, in any units of these kinds.
    rows : tuple of tuple of float
        Instead of a file: t, vx, vy, vz, wx, wy, wz.
    duration : float
        No longer than this, s; the last row ends it.
    """

    file: Path | None = None
    rows: tuple[Row, ...] = ()

    def __post_init__(self) -> None:
        if (self.file is not None) == bool(self.rows):
            raise ValueError("give a file or rows, and not both.")

    def known(self) -> list[Row]:
        """Return the rows; see `ArmTwists.known`."""
        if self.file is not None:
            rows, name = read_rows(Path(self.file)), f"{self.file}: "
        else:
            rows, name = list(self.rows), ""
        if len(rows) < 2:
            raise InfeasibleMotion(f"{name}there is no twist: the last of two rows says the end.")
        for number, (before, after) in enumerate(pairwise(rows), 2):
            if not before[0] < after[0]:
                raise InfeasibleMotion(
                    f"{name}row {number} is for {after[0]:g} s, and must be after row "
                    f"{number - 1} ({before[0]:g} s)."
                )
        for number, (_, *twist) in enumerate(rows, 1):
            if max(map(abs, twist)) > FASTEST:
                raise InfeasibleMotion(
                    f"{name}row {number} asks for {max(twist, key=abs):g} m/s or rad/s; no arm is "
                    f"faster than {FASTEST:g}."
                )
        if rows[0][0] < 0.0:
            raise InfeasibleMotion(f"{name}row 1 is for {rows[0][0]:g} s, before the beginning.")
        return rows

    def twist(self, t: float) -> Six:
        """Return the row at an instant."""
        return twist_at(self.known(), t)


def twist_at(rows: Sequence[Row], t: float) -> Six:
    """Return the twist of the last row that has begun; before the first and after the last none."""
    number = bisect_right(rows, t, key=lambda row: row[0]) - 1
    if not 0 <= number < len(rows) - 1:
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return rows[number][1:]


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a CSV file, in SI.

    Raises
    ------
    InfeasibleMotion
        With the line and what is wrong with it.
    """
    lines = read_table(path)
    names = _columns(path, lines[0] if lines else [])
    rows: list[Row] = []
    for number, line in enumerate(lines[1:], 2):
        if not line:
            continue
        if len(line) != len(names):
            raise InfeasibleMotion(
                f"{path}, line {number}: {len(line)} values, the header has {len(names)}."
            )
        told = {
            name: scale * _number(path, number, text)
            for (name, scale), text in zip(names, line, strict=True)
        }
        t, vx, vy, vz, wx, wy, wz = (told.get(name, 0.0) for name in _UNITS)
        rows.append((t, vx, vy, vz, wx, wy, wz))
    return rows


def _columns(path: Path, header: list[str]) -> list[tuple[str, float]]:
    """Return each column's name, and by what its values are multiplied."""
    found: list[tuple[str, float]] = []
    for text in header:
        name, _, unit = text.replace("(", " ").replace(")", " ").strip().partition(" ")
        if name not in _UNITS or name in dict(found):
            raise InfeasibleMotion(
                f"{path}, line 1: the column {text.strip()!r} is "
                f"{'there twice' if name in _UNITS else 'unknown'}; columns are "
                f"{', '.join(_UNITS)}, each once."
            )
        units = _UNITS[name]
        if unit.strip() not in units:
            raise InfeasibleMotion(
                f"{path}, line 1: the unit of {name} is {unit.strip() or 'missing'}; write "
                f"{name} ({next(iter(units))}), or one of {', '.join(units)}."
            )
        found.append((name, units[unit.strip()]))
    names = dict(found)
    turning = [name for name in _ANGULAR if name in names]
    if not all(name in names for name in ("t", *_LINEAR)) or 0 < len(turning) < len(_ANGULAR):
        raise InfeasibleMotion(
            f"{path}, line 1: the header has to name t, vx, vy and vz, and all of wx, wy, wz or "
            f"none; it has {', '.join(names) or 'nothing'}."
        )
    return found


def _number(path: Path, line: int, text: str) -> float:
    value = number_in(text)
    if not math.isfinite(value):
        raise InfeasibleMotion(f"{path}, line {line}: {text!r} is no number.")
    return value
