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
from controllers.arm.online.twist_file import Row, read_rows
from controllers.motion import InfeasibleMotion

Silence = Annotated[float, Unit("s"), Interval(gt=0, le=0.1)]

FASTEST = 1000.0
"""m/s or rad/s: what is more is a mistake, and squared no number."""
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
        if self.file is None:
            named = [(f"row {number}", row) for number, row in enumerate(self.rows, 1)]
        else:
            named = [(f"line {line}", row) for line, row in read_rows(Path(self.file))]
        name = "" if self.file is None else f"{self.file}: "
        if len(named) < 2:
            raise InfeasibleMotion(f"{name}there is no twist: the last of two rows says the end.")
        for where, (t, *twist) in named:
            if max(map(abs, twist)) > FASTEST:
                raise InfeasibleMotion(
                    f"{name}{where} asks for {max(twist, key=abs):g} m/s or rad/s; no arm is "
                    f"faster than {FASTEST:g}."
                )
            if t < 0.0:
                raise InfeasibleMotion(f"{name}{where} is for {t:g} s, before the beginning.")
        for (before, (earlier, *_)), (where, (t, *_)) in pairwise(named):
            if not earlier < t:
                raise InfeasibleMotion(
                    f"{name}{where} is for {t:g} s, and must be after {before} ({earlier:g} s)."
                )
        return [row for _, row in named]

    def twist(self, t: float) -> Six:
        """Return the row at an instant."""
        return twist_at(self.known(), t)


def twist_at(rows: Sequence[Row], t: float) -> Six:
    """Return the twist of the last row that has begun; before the first and after the last none."""
    number = bisect_right(rows, t, key=lambda row: row[0]) - 1
    if not 0 <= number < len(rows) - 1:
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return rows[number][1:]
