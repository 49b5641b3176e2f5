"""Glides to and fro at one speed that are shaken on their way, of a place or an angle.

While a pair glides, friction is a constant, and what is left of it is linear: what becomes of a
small shake says how far its loop is from instability (`rig.mechanisms.pneumatic.shaken_pair`).
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from controllers.minimum_jerk import minimum_jerk
from rig.hal.formats import format_quantity
from rig.hal.measured_loop import Array
from rig.hal.motion import Segment

HARMONICS: Final = (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20)
"""Of a shake, if nothing else is said."""
_TAPER = 6.0
"""Hz: up to here all sines shake with the same speed. Beyond, it falls with the square of the
frequency: what a slow regulator has to do for a speed grows as fast."""
_FADE = 0.1
"""s, at the end of a glide."""
_FINE = 2000
"""Instants of a period at which the greatest speed of the shake is looked for."""

Moved = tuple[float, float, float]
"""A place and its first two derivatives by time, SI."""


class ShakenGlides:
    """The motion along a line, or through an angle.

    Parameters
    ----------
    travel : float
        Half the stroke of a glide, m or rad.
    speed : float
        Of the glides, m/s or rad/s.
    shake : float
        Greatest speed of the shake, as a share of that of the glide.
    period : float
        Of the shake, s; each glide is judged over one.
    harmonics : sequence of int
        Which multiples of its frequency it has, the least first.
    settle : float
        Time from the beginning of a glide until it is judged, s; the shake grows in its first half.
    turn : float
        Time in which a glide starts and ends, s.
    repeats : int
        Glides to and fro.
    unit : str
        Of `travel`, for messages.

    Raises
    ------
    ValueError
        A glide is over before it was judged, or harmonics are not in order.
    """

    def __init__(
        self,
        travel: float,
        speed: float,
        shake: float,
        period: float,
        harmonics: Sequence[int],
        settle: float,
        turn: float,
        repeats: int,
        unit: str,
    ) -> None:
        takes = turn + settle + period + _FADE
        glide = 2.0 * travel / speed
        if glide < takes:
            way, fast = (
                format_quantity(value, of) for value, of in
                ((2.0 * travel, unit), (speed, f"{unit}/s"))
            )  # fmt: skip
            raise ValueError(
                f"a glide of {way} at {fast} takes {glide:.3g} s, less than turn, settle, period "
                f"and {_FADE:g} s in which the shake fades, {takes:.3g} s: travel farther, or "
                "slower."
            )
        if list(harmonics) != sorted(set(harmonics)):
            raise ValueError("harmonics: each is larger than the one before it.")
        self._travel, self._speed, self._turn = travel, speed, turn
        self._settle, self._period = settle, period
        self._stroke = glide + turn
        self._count = 2 * repeats
        self._lines = self._shaken(harmonics, shake)

    @property
    def frequencies(self) -> Array:
        """Of the shake, Hz."""
        return np.array([w for _, w, _ in self._lines]) / (2.0 * math.pi)

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._count * self._stroke

    @property
    def segments(self) -> tuple[Segment, ...]:
        """One period of the shake in each glide, ``"glide +1"``."""
        starts = [number * self._stroke + self._turn + self._settle
                  for number in range(self._count)]  # fmt: skip
        return tuple(
            Segment(f"glide {'-' if number % 2 else '+'}{number // 2 + 1}", at, at + self._period)
            for number, at in enumerate(starts)
        )

    def at(self, t: float) -> Moved:
        """Return place, speed and acceleration at `t`."""
        number = min(int(t // self._stroke), self._count - 1)
        into = t - number * self._stroke
        sign = -1.0 if number % 2 else 1.0
        place, speed, rise = (sign * part for part in self._glide(into))
        grown = self._grown(into - self._turn)
        if not grown[0]:
            return place, speed, rise
        shaken = _sum(self._lines, into - self._turn - self._settle)
        return (
            place + grown[0] * shaken[0],
            speed + grown[0] * shaken[1] + grown[1] * shaken[0],
            rise + grown[0] * shaken[2] + 2.0 * grown[1] * shaken[1] + grown[2] * shaken[0],
        )

    def _glide(self, into: float) -> Moved:
        """Return the motion of a glide that goes up: even speed between parabolic turns."""
        travel, speed, turn = self._travel, self._speed, self._turn
        rise = speed / turn
        if into < turn:
            return 0.5 * rise * into * into - travel, rise * into, rise
        if into < self._stroke - turn:
            return speed * (into - 0.5 * turn) - travel, speed, 0.0
        left = max(self._stroke - into, 0.0)
        return travel - 0.5 * rise * left * left, rise * left, -rise if left > 0.0 else 0.0

    def _shaken(self, harmonics: Sequence[int], shake: float) -> tuple[Moved, ...]:
        """Return amplitude (m or rad), angular frequency (rad/s) and phase of each sine."""
        count = len(harmonics)
        lines = []
        for number, harmonic in enumerate(harmonics):
            frequency = harmonic / self._period
            speed = min(1.0, (_TAPER / frequency) ** 2)
            w = 2.0 * math.pi * frequency
            # Schroeder's phases: the sines do not add up at one instant.
            lines.append((speed / w, w, -math.pi * number * (number + 1) / count))
        instants = [self._period * k / _FINE for k in range(_FINE)]
        greatest = max(abs(_sum(lines, t)[1]) for t in instants)
        share = shake * self._speed / greatest
        return tuple((share * amplitude, w, phase) for amplitude, w, phase in lines)

    def _grown(self, into: float) -> Moved:
        """Return which share of the shake there is, and its first two derivatives by time."""
        end = self._stroke - 2.0 * self._turn
        if not 0.0 < into < end:
            return 0.0, 0.0, 0.0
        if into < 0.5 * self._settle:
            return minimum_jerk(0.0, 1.0, 0.5 * self._settle, into)
        if into > end - _FADE:
            return minimum_jerk(1.0, 0.0, _FADE, into - end + _FADE)
        return 1.0, 0.0, 0.0


def _sum(lines: Sequence[Moved], t: float) -> Moved:
    """Return place, speed and acceleration of a sum of sines."""
    place = speed = rise = 0.0
    for amplitude, w, phase in lines:
        sine, cosine = math.sin(w * t + phase), math.cos(w * t + phase)
        place += amplitude * sine
        speed += amplitude * w * cosine
        rise -= amplitude * w * w * sine
    return place, speed, rise
