"""Glides of a pair that no controller shakes: from standstill to standstill on a soft spring.

Under a position controller a pair of standard seals slips and sticks at any speed that is of
interest: the regulators answer later than the seals change. So the force of the chambers rises
slowly until the pair breaks away, and then follows a spring that is softer than anything else in
the rig, pulled along at a speed that falls. On it the seals' own viscous friction keeps the pair
sliding, down to the speed below which friction falls faster with the speed than that can hold.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final, NamedTuple

from annotated_types import Gt, Unit

from controllers.cylinder.types import PairCommand, PairModel, PairReference, PairState
from controllers.minimum_jerk import minimum_jerk
from rig.calibration.sequence import ScriptedMotion
from rig.hal.motion import Segment

_BROKEN: Final = 0.3e-3
"""A pair that is so far from where it stood has broken away, m: ten times what seals give."""

_AHEAD: Final = 0.11
"""By how much the force that was sent is ahead of the chambers', and a pair that has broken away
wants less, s of its rise."""

_STUCK: Final = (0.05, 0.1e-3)
"""A pair that has moved by less than so much (m) in such a time (s) has stopped."""

_CAUGHT: Final = 0.25
"""A pair that stops sooner after it has broken away was given too little: the spring goes on, s."""

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
        Of the spring, N/m.
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
    stiffness: Annotated[float, Unit("N/m"), Gt(0)] = 500.0
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
    def segments(self) -> tuple[Segment, ...]:
        """Each glide, from where the force begins to rise."""
        return tuple(Segment(glide.name, glide.rise, glide.end) for glide in self.glides())

    def way(self, t: float) -> float:
        """Return how far the spring's end is pulled `t` seconds after the pair broke away, m."""
        faster = (self.fastest - self.slowest) * self.slowing
        return self.slowest * t + faster * (1.0 - math.exp(-t / self.slowing))


class Gliding(ScriptedMotion[PairReference]):
    """Does the glides; to the runtime it is the motion and its controller in one.

    Parameters
    ----------
    settings : Glides
        What is to be done.
    controller : object
        Takes the pair to where a glide starts.
    model : PairModel
        Of the pair.
    """

    def __init__(self, settings: Glides, controller: Any, model: PairModel) -> None:
        self.settings = settings
        super().__init__(settings.duration, settings.segments)
        self.estimate = controller.estimate
        self._controller = controller
        self._area = model.area
        self._glides: Sequence[Glide] = list(settings.glides())
        self._t = 0.0
        self._restart()

    def _restart(self) -> None:
        self._number = 0
        self._from: float | None = None
        self._stood = self._sent = 0.0
        self._broke: tuple[float, float, float] | None = None
        self._mark = (0.0, 0.0)
        self._done = False

    def at(self, t: float) -> PairReference:
        """Take the time, and return where this glide starts: what comes then no one can plan."""
        self._t = t
        return PairReference(-self._glide_at(t).side * self.settings.travel, 0.0, 0.0)

    def _glide_at(self, t: float) -> Glide:
        each = self._glides[0].end
        return self._glides[min(max(int(t / each), 0), len(self._glides) - 1)]

    def reset(self, state: PairState) -> None:
        """Start over."""
        self._restart()
        self._controller.reset(state)

    def update(self, state: PairState, reference: PairReference) -> PairCommand:
        """Return the command of this instant."""
        t = self._t
        number = self._glides.index(self._glide_at(t))
        glide = self._glides[number]
        if number != self._number:
            self._number, self._from, self._done = number, state.position, False
            self._controller.reset(state)
        if t < glide.start + self.settings.move:
            return self._go(state, reference, t - glide.start)
        if t < glide.rise:
            self._stood, self._sent, self._broke = state.position, 0.0, None
        elif not self._done:
            self._pull(state, glide)
        # Neither chamber slack nor above twice its mean.
        most = min(self.settings.most, 2.0 * self._area * (glide.base - _FLOOR))
        half = 0.5 * glide.side * min(max(self._sent, 0.0), most) / self._area
        return PairCommand(glide.base + half, glide.base - half)

    def _go(self, state: PairState, reference: PairReference, since: float) -> PairCommand:
        if self._from is not None:  # else the approach has brought it there
            way = 0.85 * self.settings.move
            there = reference.position
            reference = PairReference(*minimum_jerk(self._from, there, way, min(since, way)))
        command: PairCommand = self._controller.update(state, reference)
        self.estimate = self._controller.estimate
        return command

    def _pull(self, state: PairState, glide: Glide) -> None:
        t, settings = self._t, self.settings
        way = glide.side * (state.position - self._stood)
        if self._broke is None:
            self._sent = settings.rate * (t - glide.rise)
            if way > _BROKEN:
                self._broke = (t, way, self._sent - _AHEAD * settings.rate)
                self._mark = (t, way)
            elif self._sent > settings.most:
                self._finish()
            return
        began, first, force = self._broke
        since = t - began
        self._sent = force + settings.stiffness * (settings.way(since) - (way - first))
        if t - self._mark[0] >= _STUCK[0]:
            stopped = since > _CAUGHT and way - self._mark[1] < _STUCK[1]
            self._mark = (t, way)
            beyond = glide.side * state.position > settings.travel
            if stopped or beyond or since > settings.longest:
                self._finish()

    def _finish(self) -> None:
        self._done, self._sent = True, 0.0
