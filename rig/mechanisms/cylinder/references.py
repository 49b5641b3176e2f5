"""References for one antagonistic pair, as an experiment names them.

Every reference starts and ends at rest, so that the loop can approach it and leave it
without a jump.
"""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, MinLen, Unit

from controllers.cylinder.types import PairReference
from controllers.minimum_jerk import minimum_jerk
from rig.hal.motion import Motion, Segment

Length = Annotated[float, Unit("m")]
Duration = Annotated[float, Unit("s"), Gt(0)]

_new = tuple.__new__  # makes a named tuple in half the time that its class takes


class PairMotion(Motion[PairReference]):
    """Base of the references of a pair."""


@dataclass(frozen=True, slots=True)
class SineTone:
    """One frequency of a sine reference.

    Parameters
    ----------
    frequency : float
        How often a second it goes there and back, Hz.
    periods : int
        Whole periods, at least two: the first half period settles and is not judged.
    """

    frequency: Annotated[float, Unit("Hz"), Gt(0)]
    periods: Annotated[int, Ge(2)] = 3


@dataclass(frozen=True, slots=True)
class Sine(PairMotion):
    """A cosine about zero, one frequency after the other.

    It starts and ends at its crest, where the velocity is zero.

    Parameters
    ----------
    amplitude : float
        How far it goes to either side of zero, m.
    tones : tuple of SineTone
        The frequencies in their order.
    """

    amplitude: Annotated[float, Unit("m"), Gt(0)]
    tones: Annotated[tuple[SineTone, ...], MinLen(1)]
    _tones: tuple[tuple[float, float, float], ...] = field(init=False, repr=False, default=())

    def __post_init__(self) -> None:
        tones = []
        start = 0.0
        for tone in self.tones:
            end = start + tone.periods / tone.frequency
            tones.append((start, end, 2.0 * math.pi * tone.frequency))
            start = end
        object.__setattr__(self, "_tones", tuple(tones))

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._tones[-1][1]

    @property
    def segments(self) -> tuple[Segment, ...]:
        """One segment per tone, ``"0.2 Hz"``, without its first half period."""
        return tuple(
            Segment(f"{tone.frequency:g} Hz", start + 0.5 / tone.frequency, end)
            for tone, (start, end, _) in zip(self.tones, self._tones, strict=True)
        )

    def at(self, t: float) -> PairReference:
        """Return the desired motion at `t`."""
        for start, end, w in self._tones:
            if t < end:
                phase = w * (t - start)
                position = self.amplitude * math.cos(phase)
                velocity = -self.amplitude * w * math.sin(phase)
                return _new(PairReference, (position, velocity, -w * w * position))
        return PairReference(self.amplitude, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Staircase(PairMotion):
    """Minimum-jerk moves between levels, with a dwell on each.

    Parameters
    ----------
    levels : tuple of float
        Positions in their order, m.
    rise : float
        Time of each move, s.
    dwell : float
        Time on each level, s; its second half is judged.
    """

    levels: Annotated[tuple[Length, ...], MinLen(2)]
    rise: Duration = 1.0
    dwell: Duration = 2.0

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self.dwell + (len(self.levels) - 1) * (self.rise + self.dwell)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The second half of each dwell, ``"hold +4 mm"``, after the first level."""
        each = self.rise + self.dwell
        return tuple(
            Segment(
                f"hold {level * 1e3:+g} mm #{number}",
                number * each + 0.5 * self.dwell,
                number * each + self.dwell,
            )
            for number, level in enumerate(self.levels)
            if number > 0
        )

    def at(self, t: float) -> PairReference:
        """Return the desired motion at `t`."""
        each = self.rise + self.dwell
        number = min(int(t // each), len(self.levels) - 1)
        if number == len(self.levels) - 1:
            return PairReference(self.levels[-1], 0.0, 0.0)
        into = t - number * each - self.dwell
        start, end = self.levels[number], self.levels[number + 1]
        return PairReference(*minimum_jerk(start, end, self.rise, into))


_LONGEST_RISE = 0.25
"""Of a step, as a share of its dwell."""


@dataclass(frozen=True, slots=True)
class Step(PairMotion):
    """Steps out and back, sudden or with a minimum-jerk rise.

    Sudden ones show a loop, and are more than seals that stick should be asked for: the pair stands
    until what is integrated breaks it away, and then slides too far.

    Parameters
    ----------
    size : float
        How far each step goes, m.
    dwell : float
        Time before and after each step begins, s.
    repeats : int
        How often out and back.
    rise : float
        Time of the reference's own way, s; 0: it jumps. At most a quarter of the dwell.
    """

    size: Length
    dwell: Duration = 3.0
    repeats: Annotated[int, Ge(1)] = 1
    rise: Annotated[float, Unit("s"), Ge(0)] = 0.0

    def __post_init__(self) -> None:
        if self.rise > _LONGEST_RISE * self.dwell:
            raise ValueError(
                f"rise is {self.rise:g} s, more than a quarter of the dwell of {self.dwell:g} s: "
                "what comes after it is what a step shows."
            )

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self.dwell * (1 + 2 * self.repeats)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """One segment per step, ``"step +5 mm"``, from the step to the end of its dwell."""
        return tuple(
            Segment(
                f"step {self.size * 1e3 * (1 if number % 2 else -1):+g} mm #{number}",
                number * self.dwell,
                (number + 1) * self.dwell,
            )
            for number in range(1, 2 * self.repeats + 1)
        )

    def at(self, t: float) -> PairReference:
        """Return the desired motion at `t`."""
        number = min(int(t // self.dwell), 2 * self.repeats)
        end = self.size if number % 2 else 0.0
        into = t - number * self.dwell
        if number == 0 or into >= self.rise:
            return PairReference(end, 0.0, 0.0)
        return PairReference(*minimum_jerk(self.size - end, end, self.rise, into))


@dataclass(frozen=True, slots=True)
class Ramp(PairMotion):
    """Slow constant-speed strokes to and fro, which show friction and stick-slip.

    Parameters
    ----------
    travel : float
        Half the stroke: from ``-travel`` to ``+travel``, m.
    speeds : tuple of float
        One stroke to and one fro at each, m/s.
    turn : float
        Time in which a stroke starts and ends, s.
    """

    travel: Annotated[float, Unit("m"), Gt(0)]
    speeds: Annotated[tuple[Annotated[float, Unit("m/s"), Gt(0)], ...], MinLen(1)]
    turn: Duration = 0.5
    _strokes: tuple[tuple[float, float, float], ...] = field(init=False, repr=False, default=())

    def __post_init__(self) -> None:
        for speed in self.speeds:
            if speed * self.turn >= 2.0 * self.travel:
                raise ValueError(
                    f"at {speed:g} m/s, starting and ending in {self.turn:g} s each uses up the "
                    f"whole stroke of {2 * self.travel:g} m."
                )
        strokes = []
        start = 0.0
        for speed in self.speeds:
            for direction in (1.0, -1.0):
                strokes.append((start, direction, speed))
                start += 2.0 * self.travel / speed + self.turn
        object.__setattr__(self, "_strokes", tuple(strokes))

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        start, _, speed = self._strokes[-1]
        return start + 2.0 * self.travel / speed + self.turn

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The constant-speed part of each stroke, ``"+2 mm/s"``."""
        return tuple(
            Segment(
                f"{direction * speed * 1e3:+g} mm/s",
                start + 2.0 * self.turn,
                start + 2.0 * self.travel / speed,
            )
            for start, direction, speed in self._strokes
        )

    def at(self, t: float) -> PairReference:
        """Return the desired motion at `t`: trapezoidal speed with parabolic turns."""
        stroke = self._strokes[0]
        for candidate in self._strokes:
            if t < candidate[0]:
                break
            stroke = candidate
        start, direction, speed = stroke
        into = t - start
        cruise_end = 2.0 * self.travel / speed
        acceleration = speed / self.turn
        if into < self.turn:
            gone, velocity, rate = 0.5 * acceleration * into**2, acceleration * into, acceleration
        elif into < cruise_end:
            gone, velocity, rate = speed * (into - 0.5 * self.turn), speed, 0.0
        else:
            left = max(cruise_end + self.turn - into, 0.0)
            gone = 2.0 * self.travel - 0.5 * acceleration * left**2
            velocity, rate = acceleration * left, -acceleration if left > 0.0 else 0.0
        return PairReference(
            direction * (gone - self.travel), direction * velocity, direction * rate
        )
