"""Slides of a joint's pairs without a controller: the excitation of friction that no law bears.

Behind late regulators a ring with more friction than was believed slips far past whatever reference
it is led along: no law takes back in time what it took to break it away. Where it then leans far,
one-sided tensions only press it on its ball.

So nobody leads it. It stands near upright, where its seals hold it by themselves. One pair is
pushed towards upright, ever harder, until it breaks away; the force that broke it, or a share of
it, slides it on. It is let go early enough to end a little past upright, and pushed back by half as
much, which is less than would break it away again. All of that is in proportion to the rig's own
friction, whatever was believed.
"""

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated, Final, NamedTuple

from annotated_types import Ge, Gt, MinLen, Unit

from rig.hal.motion import Segment

GOAL: Final = 3.5e-3
"""So far past upright a slide should end, m: seals with 0.6 of their friction still hold it."""

LATE: Final = 0.05
"""How long a pair slides on at the speed with which it was let go, before that has been seen, s."""

_SHARES: Final = (0.85, 1.0, 1.15)
"""Of the force that broke a pair away, what slides it on, by turns: speed is then no function of
the place."""

_BACK: Final = 0.5
"""Share of that force with which a pair is pushed back once it is let go."""

_AGAIN: Final = 1.4
"""The second base pressure leaves the wire that is let go taut under so many times the force that
broke the pairs away at the first: their tensions then tell from that force."""

_SPEED_OVER: Final = 8e-3
"""Time over which a speed is taken, s."""

_SLID: Final = 10e-3
"""A pair that was let go at less than this speed says nothing of how long it slides on, m/s."""

_LONGEST: Final = 0.2
"""The longest that is learnt of that, s."""


class Slide(NamedTuple):
    """One slide.

    Parameters
    ----------
    name : str
        Of its stretch.
    pair : int
        0 or 1.
    share : float
        Of the force that breaks the pair away, what slides it on.
    again : bool
        Whether it is at the second base pressure.
    rise, end : float
        When its force begins to rise, and when it is over, s.
    """

    name: str
    pair: int
    share: float
    again: bool
    rise: float
    end: float


@dataclass(frozen=True, slots=True)
class Slides:
    """Slides of both pairs by turns, at two base pressures.

    The force rises evenly at first and then in proportion to itself: what it has risen on by until
    late air arrives is the same share of it on every rig.

    Parameters
    ----------
    base, highest : float
        First base pressure, and the greatest that the second one may be, Pa gauge.
    most : float
        Greatest force, N.
    count : int
        Slides of each pair at each base pressure.
    first : float
        Force up to which it rises evenly, N.
    grow : float
        Time for that, and for the growth by e afterwards, s.
    rest : float
        Before the force rises, and after the longest rise, s.
    """

    base: Annotated[float, Unit("Pa"), Gt(0)]
    highest: Annotated[float, Unit("Pa"), Gt(0)]
    most: Annotated[float, Unit("N"), Gt(0)]
    count: Annotated[int, Ge(1)] = 9
    first: Annotated[float, Unit("N"), Gt(0)] = 8.0
    grow: Annotated[float, Unit("s"), Gt(0)] = 0.8
    rest: Annotated[float, Unit("s"), Gt(0)] = 0.4
    _slides: Annotated[tuple[Slide, ...], MinLen(1)] = field(init=False, repr=False, default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "_slides", tuple(self._plan()))

    def _plan(self) -> Iterator[Slide]:
        each = 2.0 * self.rest + self.rising
        for number in range(4 * self.count):
            turn, pair = divmod(number, 2)
            name = f"slide {number + 1} of pair {pair + 1}"
            share, start = _SHARES[turn % len(_SHARES)], number * each
            yield Slide(name, pair, share, turn >= self.count, start + self.rest, start + each)

    @property
    def slides(self) -> tuple[Slide, ...]:
        """The slides in their order."""
        return self._slides

    @property
    def duration(self) -> float:
        """How long they take, s."""
        return self._slides[-1].end

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Each slide from where its force begins to rise."""
        return tuple(Segment(slide.name, slide.rise, slide.end) for slide in self._slides)

    @property
    def rising(self) -> float:
        """How long the force rises until it is greatest, s."""
        return self.grow * (1.0 + math.log(max(self.most / self.first, 1.0)))

    def risen(self, passed: float) -> float:
        """Return the force, N, after it has risen for a time, s."""
        share = passed / self.grow
        force = self.first * (max(share, 0.0) if share < 1.0 else math.exp(share - 1.0))
        return min(force, self.most)

    def second(self, broke: float, least: float, area: float) -> float:
        """Return the second base pressure, Pa gauge.

        Parameters
        ----------
        broke : float
            Force that broke the pairs away at the first one, N.
        least : float
            Tension under which a wire is not let, N.
        area : float
            Of a chamber, m².
        """
        taut = (least + 0.5 * _AGAIN * broke) / area
        return min(max(self.base, taut), max(self.base, self.highest))


class Release:
    """The push of one slide: until the pair breaks away, while it slides, once it is let go.

    Parameters
    ----------
    stood : float
        Where the pair stands, m; it is pushed towards 0.
    late : float
        For how long it is expected to slide on at the speed with which it is let go, s.
    goal : float
        How far past 0 it should end, m.
    share : float
        Of the force that breaks it away, what slides it on.
    """

    def __init__(self, stood: float, late: float, goal: float, share: float = 1.0) -> None:
        self._stood, self._late, self._goal, self._share = stood, late, goal, share
        self._past: deque[tuple[float, float]] = deque()
        self._speed = 0.0
        self.side = -1.0 if stood > 0.0 else 1.0
        """+1 or -1: where to."""
        self.broke = math.nan
        """The force that broke it away, N; NaN before."""
        self.let_go = math.nan
        """Where it was let go, m; NaN before."""

    def force(self, t: float, place: float, risen: float, broken: float) -> float:
        """Return the force of a cycle, N, with its sign.

        Parameters
        ----------
        t : float
            Of the cycle, s.
        place : float
            Where the pair is, m.
        risen : float
            What the force has risen to if the pair still stands, N.
        broken : float
            So far from where it stood a pair has broken away, m.
        """
        past = self._past
        past.append((t, place))
        while len(past) > 2 and past[1][0] <= t - _SPEED_OVER:
            past.popleft()
        if math.isnan(self.broke):
            if self.side * (place - self._stood) < broken:
                return self.side * risen
            self.broke = risen
        if math.isnan(self.let_go):
            before, where = past[0]
            self._speed = self.side * (place - where) / (t - before) if t > before else 0.0
            if self.side * place + self._late * self._speed >= self._goal:
                self.let_go = place
        return self.side * self.broke * (self._share if math.isnan(self.let_go) else -_BACK)

    def late(self, ended: float) -> float:
        """Return how long it takes the next one to slide on, s, given where this one ended, m."""
        if math.isnan(self.let_go) or self._speed < _SLID:
            return self._late
        seen = self.side * (ended - self.let_go) / self._speed
        return min(max(0.5 * (seen + self._late), 0.0), _LONGEST)
