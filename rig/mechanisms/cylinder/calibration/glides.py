"""Glides of a pair that no controller shakes: from standstill to standstill on a soft spring.

Under a position controller a pair of standard seals slips and sticks at any speed that is of
interest: the regulators answer later than the seals change. So the force of the chambers rises
slowly until the pair breaks away, and then follows a spring that is softer than anything else in
the rig, pulled along at a speed that falls. On it the seals' own viscous friction keeps the pair
sliding, down to the speed below which friction falls faster with the speed than that can hold.
"""

import math
from collections import deque
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from typing import Annotated, Final, NamedTuple

from annotated_types import Gt, Unit

from controllers.cylinder.types import PairCommand, PairReference, PairState
from controllers.minimum_jerk import minimum_jerk
from rig.calibration.sequence import EstimatingController, GuidedScript
from rig.config import format_quantity
from rig.hal.motion import Segment

_BROKEN: Final = 0.3e-3
"""A pair that is so far from where it stood has broken away, m: ten times what seals give."""

_LESS: Final = 0.17
"""A pair that has broken away wants less force than was sent, by this share of it: what was sent is
ahead of the chambers', and seals that slide take less. Whose seals take little would stop at once
for as much as others need."""

_STUCK: Final = (0.05, 0.1e-3)
"""A pair that has moved by less than so much (m) in such a time (s) has stopped."""

_CAUGHT: Final = 0.25
"""A pair that stops sooner after it has broken away was given too little: the spring goes on, s."""

_SHORT: Final = 0.5
"""Share of half the permitted way short of which a glide is done once more: it tells too little."""

_LATELY: Final = 0.02
"""A speed is that of so long a time, s."""

_AHEAD: Final = 0.08
"""So long after it is let go a pair is still pulled, s: dead time and lag of the regulators."""

_ROOM: Final = 1.1
"""Times half the permitted way: a pair that would be beyond that by then is let go before. Some
seals let a heavy carriage go faster than the spring is pulled."""

_FLOOR: Final = 15e3
"""No chamber goes below, Pa gauge: its wire would go slack."""


class Glide(NamedTuple):
    """One glide.

    Parameters
    ----------
    name : str
        Of its stretch.
    side : int
        +1 or -1: where to.
    base : float
        Mean pressure, Pa gauge.
    start : float
        When the pair begins to go where it glides from, s.
    rise : float
        When the force begins to rise, s.
    end : float
        s.
    """

    name: str
    side: int
    base: float
    start: float
    rise: float
    end: float


@dataclass(frozen=True, slots=True)
class Glides:
    """Glides to and fro, a pair of them at each mean pressure.

    Parameters
    ----------
    travel : float
        Half the way that is permitted, m.
    bases : tuple of float
        Mean pressures of the pairs of glides, Pa gauge.
    fastest, slowest : float
        Speed of the spring's end at the beginning, and which it comes near, m/s.
    slowing : float
        Time constant with which it does, s: the slower the pair is, the more slowly it changes,
        since its seals' bristles follow only after some way.
    longest : float
        Time after which a glide is over, s.
    stiffness : float
        Of the spring, N/m. Behind regulators that are T late it takes damping from the pair, its
        stiffness times T: 12 N s/m for 40 ms, where the seals that damp least have 18.
    rate : float
        Of the force until the pair breaks away, N/s.
    most : float
        Greatest force, N.
    move, rest : float
        Time to go where a glide starts, and to rest there, s.
    """

    travel: Annotated[float, Unit("m"), Gt(0)]
    bases: tuple[Annotated[float, Unit("Pa"), Gt(0)], ...]
    fastest: Annotated[float, Unit("m/s"), Gt(0)] = 0.04
    slowest: Annotated[float, Unit("m/s"), Gt(0)] = 0.010
    slowing: Annotated[float, Unit("s"), Gt(0)] = 0.45
    longest: Annotated[float, Unit("s"), Gt(0)] = 1.6
    stiffness: Annotated[float, Unit("N/m"), Gt(0)] = 300.0
    rate: Annotated[float, Unit("N/s"), Gt(0)] = 20.0
    most: Annotated[float, Unit("N"), Gt(0)] = 30.0
    move: Annotated[float, Unit("s"), Gt(0)] = 1.4
    rest: Annotated[float, Unit("s"), Gt(0)] = 0.4

    def glides(self) -> Iterator[Glide]:
        """Yield the glides in their order."""
        each = self.move + self.rest + self.most / self.rate + self.longest
        for k, base in enumerate(base for base in self.bases for _ in (0, 1)):
            side = 1 if k % 2 == 0 else -1
            start = k * each
            rise = start + self.move + self.rest
            name = f"glide {k + 1} {'+' if side > 0 else '-'}"
            yield Glide(name, side, base, start, rise, start + each)

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return max((glide.end for glide in self.glides()), default=0.0)

    @property
    def least_way(self) -> float:
        """Way of a glide that tells anything, m."""
        return 0.3 * self.travel

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Each glide, from where the force begins to rise."""
        return tuple(Segment(glide.name, glide.rise, glide.end) for glide in self.glides())

    def way(self, t: float) -> float:
        """Return how far the spring's end is pulled `t` seconds after the pair broke away, m."""
        faster = (self.fastest - self.slowest) * self.slowing
        return self.slowest * t + faster * (1.0 - math.exp(-t / self.slowing))


class GlideScript(GuidedScript[PairReference, PairState, PairCommand]):
    """Takes the pair to where each glide starts, and lets it glide.

    Parameters
    ----------
    settings : Glides
        What is to be done.
    controller : EstimatingController
        Takes the pair to where a glide starts.
    area : float
        Effective piston area of a chamber, m².
    """

    def __init__(
        self,
        settings: Glides,
        controller: EstimatingController[PairReference, PairState, PairCommand],
        area: float,
    ) -> None:
        super().__init__(settings.duration, settings.segments, controller)
        self.settings = settings
        self._area = area
        self._glides = list(settings.glides())

    def describe(self) -> Iterator[str]:
        """Yield where the pair goes and what pulls it."""
        glides = self.settings
        low, high = (format_quantity(side * glides.travel, "m") for side in (-1.0, 1.0))
        force, rate = format_quantity(glides.most, "N"), format_quantity(glides.rate, "N/s")
        speed = format_quantity(glides.fastest, "m/s")
        least, most = (format_quantity(f(glides.bases), "Pa") for f in (min, max))
        yield f"the pair moves {low} … {high} and glides between them, no controller holding it"
        yield f"to break it away, a force that rises by {rate}, up to {force}"
        yield f"then a spring of {glides.stiffness:g} N/m, pulled at {speed} and ever more slowly"
        yield f"mean pressures {least} … {most}"

    def reference_at(self, t: float) -> PairReference:
        """Return where this glide starts: what comes then no one can plan."""
        return PairReference(-self._glide_at(t).side * self.settings.travel, 0.0, 0.0)

    def _glide_at(self, t: float) -> Glide:
        each = self._glides[0].end
        return self._glides[min(max(int(t / each), 0), len(self._glides) - 1)]

    def play(self) -> Iterator[PairCommand]:
        """Go to each glide's start, rest, glide, and rest where the pair has stopped."""
        start: float | None = None  # the approach brings it to the first one
        for glide in self._glides:
            while self.t < glide.start + self.settings.move:
                yield self._go(start, self.t - glide.start)
            stood = self.state.position
            while self.t < glide.rise:
                stood = self.state.position
                yield self._pressures(glide, 0.0)
            pull = self._pull(glide, stood)
            while self._glide_at(self.t) is glide:
                yield self._pressures(glide, next(pull, 0.0))
            start = self.state.position
            self.controller.reset(self.state)

    def _go(self, start: float | None, since: float) -> PairCommand:
        reference = self.wanted
        if start is not None:
            way = 0.85 * self.settings.move
            there = reference.position
            reference = PairReference(*minimum_jerk(start, there, way, min(since, way)))
        return self.follow(reference)

    def _pressures(self, glide: Glide, force: float) -> PairCommand:
        # Neither chamber slack nor above twice its mean.
        most = min(self.settings.most, 2.0 * self._area * (glide.base - _FLOOR))
        half = 0.5 * glide.side * min(max(force, 0.0), most) / self._area
        return PairCommand(glide.base + half, glide.base - half)

    def _pull(self, glide: Glide, stood: float) -> Iterator[float]:
        """Yield the force (N) until the pair has glided and stopped, or does not move at all.

        Whose seals' breakaway and regulators' hysteresis together ask for more than is taken off
        stops after some millimetres; it is broken away once more, and given half as much less.

        Parameters
        ----------
        glide : Glide
            Which one.
        stood : float
            Where the pair stands, m.
        """
        settings, less = self.settings, _LESS
        begun, held = glide.rise, 0.0
        while True:
            rested = glide.side * (self.state.position - stood)
            while True:
                force = held + settings.rate * (self.t - begun)
                if glide.side * (self.state.position - stood) - rested > _BROKEN:
                    break
                if force > settings.most:
                    return
                yield force
            stopped_at = yield from self._slide(glide, stood, force, less)
            if stopped_at is None or less < _LESS:
                return
            begun, held, less = self.t, stopped_at, 0.5 * _LESS

    def _slide(
        self, glide: Glide, stood: float, force: float, less: float
    ) -> Generator[float, None, float | None]:
        """Yield the force of the spring (N) until the pair has stopped.

        Returns
        -------
        stopped_at : float or None
            The force if it has stopped before it has gone far enough to tell anything.
        """
        settings = self.settings
        first = glide.side * (self.state.position - stood)
        began, at_first = self.t, (1.0 - less) * force
        looked, was = began, first
        lately = deque([(began, first)])
        yield force
        while True:
            since, way = self.t - began, glide.side * (self.state.position - stood)
            force = at_first + settings.stiffness * (settings.way(since) - (way - first))
            lately.append((self.t, way))
            while self.t - lately[0][0] > _LATELY:
                lately.popleft()
            speed = (way - lately[0][1]) / max(self.t - lately[0][0], _LATELY)
            if glide.side * self.state.position + _AHEAD * speed > _ROOM * settings.travel:
                return None
            if self.t - looked >= _STUCK[0]:
                stopped = since > _CAUGHT and way - was < _STUCK[1]
                looked, was = self.t, way
                beyond = glide.side * self.state.position > settings.travel
                if stopped and way < _SHORT * settings.travel:
                    return force
                if stopped or beyond or since > settings.longest:
                    return None
            yield force
