"""The fastest stretches of a motion one after another, for who has not the time for all of it."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import accumulate, pairwise

from rig.hal import Mechanism, Motion, Segment
from rig.runtime.braking import Braking

WHOLE = 6.0
"""A motion that takes no longer is looked at as a whole, s."""
_COUNT = 4
_LENGTH = 1.0
_RAMP = 0.25
_BRIDGE = 0.8
_GRID = 0.02

AnyMechanism = Mechanism[object, object, object, object]


def fastest(mechanism: type[AnyMechanism], motion: Motion[object]) -> list[tuple[float, float]]:
    """Return the stretches of a motion, s, in which it is fastest, in their order.

    They do not overlap, and leave room for getting up to speed and for braking. By the way of their
    first halves: what a jump does comes after it.
    """
    last = motion.duration - _LENGTH - _RAMP
    starts = [_RAMP + k * _GRID for k in range(max(int((last - _RAMP) / _GRID), 1))]
    half = round(0.5 * _LENGTH / _GRID)
    places = [motion.at(_RAMP + k * _GRID) for k in range(len(starts) + half)]
    way = [0.0, *accumulate(mechanism.pace_between(*two, _GRID) for two in pairwise(places))]
    paces = {start: way[k + half] - way[k] for k, start in enumerate(starts)}
    found: list[float] = []
    for start in sorted(starts, key=lambda start: -paces[start]):
        if all(abs(start - other) >= _LENGTH + 2.0 * _RAMP for other in found):
            found.append(start)
            if len(found) == _COUNT:
                break
    return [(start, start + _LENGTH) for start in sorted(found)]


class Excerpts(Motion[object]):
    """A motion's stretches, each entered from rest and left to rest, with ways between them.

    Parameters
    ----------
    mechanism : type
        Says how a reference is passed more slowly, and how one gets from rest to rest.
    motion : Motion
        The whole.
    stretches : sequence of tuple of float
        Start and end of each, s.
    """

    def __init__(
        self,
        mechanism: type[AnyMechanism],
        motion: Motion[object],
        stretches: Sequence[tuple[float, float]],
    ) -> None:
        self._motion = motion
        self._mechanism = mechanism
        self._begins: list[float] = []
        self._pieces: list[Callable[[float], object]] = []
        self._stretches: list[tuple[float, float, float]] = []
        self._length = 0.0
        for start, end in stretches:
            self._add_stretch(start, end)

    def _add_stretch(self, start: float, end: float) -> None:
        mechanism, motion = self._mechanism, self._motion
        first = self._entered(start, 0.0)
        if self._pieces:
            rest = self._pieces[-1](_RAMP)
            self._add(_BRIDGE, lambda t: mechanism.approach(rest, first, _BRIDGE, t))
        self._add(_RAMP, lambda t: self._entered(start, t))
        self._stretches.append((self._length, self._length + end - start, start - self._length))
        self._add(end - start, lambda t: motion.at(start + t))
        self._add(_RAMP, Braking(mechanism.slow_down, motion.at, end, motion.duration, _RAMP).at)

    def _add(self, length: float, piece: Callable[[float], object]) -> None:
        self._begins.append(self._length)
        self._pieces.append(piece)
        self._length += length

    def _entered(self, start: float, t: float) -> object:
        """Return the reference that gets up to speed: braking with the time turned round."""
        share = t / _RAMP
        gone = _RAMP * (share**3 - 0.5 * share**4)
        rate, change = share * share * (3.0 - 2.0 * share), 6.0 * share * (1.0 - share) / _RAMP
        reference = self._motion.at(start - 0.5 * _RAMP + gone)
        return self._mechanism.slow_down(reference, rate, change)

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._length

    @property
    def segments(self) -> tuple[Segment, ...]:
        """None: nothing is measured."""
        return ()

    def at(self, t: float) -> object:
        """Return the reference at `t`."""
        number = bisect_right(self._begins, t) - 1
        return self._pieces[number](t - self._begins[number])

    def original(self, t: float) -> float | None:
        """Return which instant of the whole motion it is at `t`, s; None on the ways between."""
        for start, end, offset in self._stretches:
            if start <= t < end:
                return t + offset
        return None
