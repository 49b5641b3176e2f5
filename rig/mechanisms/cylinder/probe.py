"""The motion that shows a loop: a pair glides to and fro and is shaken on its way.

While it glides, friction is a constant, and what is left of the pair is linear: what becomes of a
small shake says how far the loop is from instability (`rig.mechanisms.cylinder.measured_loop`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Interval, MinLen, Unit

from controllers.cylinder.types import PairReference
from controllers.minimum_jerk import minimum_jerk
from rig.hal.motion import Segment
from rig.mechanisms.cylinder.references import Duration, PairMotion, Ramp

_TAPER = 6.0
"""Hz: up to here all sines shake with the same speed. Beyond, it falls with the square of the
frequency: what a slow regulator has to do for a speed grows as fast."""
_FADE = 0.1
"""s, at the end of a glide."""
_FINE = 2000
"""Instants of a period at which the greatest speed of the shake is looked for."""
_HARMONICS = (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20)


@dataclass(frozen=True, slots=True)
class Probe(PairMotion):
    """Glides to and fro at one speed, with a sum of sines on top.

    Parameters
    ----------
    travel : float
        Half the stroke of a glide, m.
    speed : float
        Of the glides, m/s: well above that from which on the seals slide.
    shake : float
        Greatest speed of the shake, as a share of that of the glide: a pair that turned round on
        its way would stick.
    period : float
        Of the shake, s; each glide is judged over one.
    harmonics : tuple of int
        Which multiples of its frequency it has, the least first.
    settle : float
        Time from the beginning of a glide until it is judged, s; the shake grows in its first half.
    turn : float
        Time in which a glide starts and ends, s.
    repeats : int
        Glides to and fro.
    """

    travel: Annotated[float, Unit("m"), Gt(0)]
    speed: Annotated[float, Unit("m/s"), Gt(0)] = 30e-3
    shake: Annotated[float, Interval(gt=0.0, le=0.9)] = 0.25
    period: Duration = 0.5
    harmonics: Annotated[tuple[Annotated[int, Ge(1)], ...], MinLen(3)] = _HARMONICS
    settle: Duration = 0.35
    turn: Duration = 0.2
    repeats: Annotated[int, Ge(2)] = 18
    _ramp: Ramp = field(init=False, repr=False)
    _lines: tuple[tuple[float, float, float], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        takes = self.turn + self.settle + self.period + _FADE
        glide = 2.0 * self.travel / self.speed
        if glide < takes:
            raise ValueError(
                f"a glide of {2e3 * self.travel:g} mm at {1e3 * self.speed:g} mm/s takes "
                f"{glide:.3g} s, less than turn, settle, period and {_FADE:g} s in which the shake "
                f"fades, {takes:.3g} s: travel farther, or slower."
            )
        if list(self.harmonics) != sorted(set(self.harmonics)):
            raise ValueError("harmonics: each is larger than the one before it.")
        ramp = Ramp(self.travel, (self.speed,) * self.repeats, self.turn)
        object.__setattr__(self, "_ramp", ramp)
        object.__setattr__(self, "_lines", self._shaken())

    def _shaken(self) -> tuple[tuple[float, float, float], ...]:
        """Return amplitude (m), angular frequency (rad/s) and phase of each sine."""
        count = len(self.harmonics)
        lines = []
        for number, harmonic in enumerate(self.harmonics):
            frequency = harmonic / self.period
            speed = min(1.0, (_TAPER / frequency) ** 2)
            w = 2.0 * math.pi * frequency
            # Schroeder's phases: the sines do not add up at one instant.
            lines.append((speed / w, w, -math.pi * number * (number + 1) / count))
        instants = [self.period * k / _FINE for k in range(_FINE)]
        greatest = max(abs(_sum(lines, t)[1]) for t in instants)
        share = self.shake * self.speed / greatest
        return tuple((share * amplitude, w, phase) for amplitude, w, phase in lines)

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._ramp.duration

    @property
    def segments(self) -> tuple[Segment, ...]:
        """One period of the shake in each glide, ``"glide +1"``."""
        return tuple(
            Segment(f"glide {'-' if number % 2 else '+'}{number // 2 + 1}",
                    start + self.settle, start + self.settle + self.period)
            for number, start in enumerate(self._starts())
        )  # fmt: skip

    def at(self, t: float) -> PairReference:
        """Return the desired motion at `t`."""
        position, velocity, acceleration = self._ramp.at(t)
        stroke = self._stroke
        into = t - (t // stroke) * stroke - self.turn
        grown = self._grown(into)
        if not grown[0]:
            return PairReference(position, velocity, acceleration)
        shaken = _sum(self._lines, into - self.settle)
        return PairReference(
            position + grown[0] * shaken[0],
            velocity + grown[0] * shaken[1] + grown[1] * shaken[0],
            acceleration + grown[0] * shaken[2] + 2.0 * grown[1] * shaken[1]
            + grown[2] * shaken[0],
        )  # fmt: skip

    @property
    def _stroke(self) -> float:
        return 2.0 * self.travel / self.speed + self.turn

    def _starts(self) -> list[float]:
        """Return when each glide has its speed, s."""
        return [number * self._stroke + self.turn for number in range(2 * self.repeats)]

    def _grown(self, into: float) -> tuple[float, float, float]:
        """Return which share of the shake there is, and its first two derivatives by time."""
        end = self._stroke - 2.0 * self.turn
        if not 0.0 < into < end:
            return 0.0, 0.0, 0.0
        if into < 0.5 * self.settle:
            return minimum_jerk(0.0, 1.0, 0.5 * self.settle, into)
        if into > end - _FADE:
            return minimum_jerk(1.0, 0.0, _FADE, into - end + _FADE)
        return 1.0, 0.0, 0.0


def _sum(lines: Sequence[tuple[float, float, float]], t: float) -> tuple[float, float, float]:
    """Return position, velocity and acceleration of a sum of sines."""
    position = velocity = acceleration = 0.0
    for amplitude, w, phase in lines:
        sine, cosine = math.sin(w * t + phase), math.cos(w * t + phase)
        position += amplitude * sine
        velocity += amplitude * w * cosine
        acceleration -= amplitude * w * w * sine
    return position, velocity, acceleration
