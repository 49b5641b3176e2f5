"""References of the crank, as an experiment names them."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Gt, MinLen, Unit

from controllers.minimum_jerk import minimum_jerk
from crank_rig.crank.types import CrankReference
from rig.hal import Motion, Segment

PEAK = 1.875
"""Of the speed of a minimum-jerk move over its mean."""


@dataclass(frozen=True, slots=True)
class CrankTurns:
    """Turns to and fro, faster each time, with a rest after each.

    Parameters
    ----------
    angle : float
        How far both cranks turn, rad.
    speeds : tuple of float
        The greatest speed of each turn, rad/s.
    rest : float
        How long they stand after each turn, s.
    """

    angle: Annotated[float, Unit("rad"), Gt(0)]
    speeds: Annotated[tuple[Annotated[float, Unit("rad/s"), Gt(0)], ...], MinLen(1)]
    rest: Annotated[float, Unit("s"), Gt(0)] = 0.2


class TurningCranks(Motion[CrankReference]):
    """Both cranks turn together; the right one leads by the rod's zero.

    Parameters
    ----------
    turns : CrankTurns
        What was asked for.
    rod_zero : float
        The right crank's lead, rad.
    """

    def __init__(self, turns: CrankTurns, rod_zero: float) -> None:
        self._rod_zero = rod_zero
        self._moves: list[tuple[float, float, float, float]] = []  # start, duration, from, to
        segments, t, here = [], 0.0, 0.0
        for number, speed in enumerate(turns.speeds):
            there = 0.0 if number % 2 else turns.angle
            duration = PEAK * turns.angle / speed
            self._moves.append((t, duration, here, there))
            way = "fro" if number % 2 else "to"
            segments.append(Segment(f"{way} at {speed:g} rad/s", t, t + duration))
            t, here = t + duration + turns.rest, there
        self._duration, self._segments = t, tuple(segments)

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._duration

    @property
    def segments(self) -> tuple[Segment, ...]:
        """One for each turn."""
        return self._segments

    def at(self, t: float) -> CrankReference:
        """Return the desired angles and speeds at `t`."""
        start, duration, here, there = next(
            move for move in reversed(self._moves) if move[0] <= t or move[0] == 0.0
        )
        angle, speed, _ = minimum_jerk(here, there, duration, t - start)
        return CrankReference((angle, angle + self._rod_zero), (speed, speed))
