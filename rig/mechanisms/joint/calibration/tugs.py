"""Tugs at a joint's pairs that stand still: the excitation of their breakaway.

Under a controller both pairs slip by turns, and each changes how the other loads the ring's seat.
So the ring stands upright, where it does not fall by itself. One pair is pushed ever harder while
the other one holds, and a controller catches the ring as soon as it has moved.

A tug depends on the tension that the one before has left: seals and ball hold both wires of a pair
up to 10 N off their chambers' pulls. It loads the seat, and no monitor sees it. So before each tug
all four pressures swing about those of rest, ever less. As many swings begin with a rise as with a
fall, and each kind of tug follows each kind equally often: what remains cancels in the mean.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated, Final, NamedTuple

from annotated_types import Ge, Gt, Unit

from controllers.spherical_joint.great_circle import great_circle
from controllers.spherical_joint.poses import Vector
from controllers.spherical_joint.types import (
    JointCommand,
    JointEstimate,
    JointReference,
    JointState,
)
from rig.calibration.sequence import EstimatingController, GuidedScript
from rig.config import format_quantity
from rig.hal.motion import Segment
from rig.mechanisms.joint.calibration.leaning import Strokes
from rig.mechanisms.joint.calibration.slides import Slides
from rig.mechanisms.joint.motion import PosedMotion

_UPRIGHT: Final = (0.0, 0.0, 1.0)
_ZERO: Final = (0.0, 0.0, 0.0)
_KINDS: Final = ((0, 1), (0, -1), (1, 1), (1, -1))
"""Pair and side."""
_ROUND: Final = (0, 0, 1, 0, 2, 0, 3, 1, 1, 2, 1, 3, 2, 2, 3, 3)
"""A de Bruijn sequence: round and round, each kind follows each once."""
_SWINGS: Final = (1, -1, -1, 1, 1, -1, 1, 1, 1, -1, -1, -1, 1, -1, -1, 1)
"""Whether pressures rise or fall first: as often of each kind, and after each kind of each pair."""
SAME, BACK, OTHER = range(3)
"""The tug before: of the same kind, at the same pair to the other side, at the other pair."""

PER_ROUND: Final = len(_ROUND) // len(_KINDS)
"""Tugs of each kind in a round."""

BROKEN: Final = 0.5e-3
"""A pair that is so far from where it stood has broken away, m: contacts and wires give less."""

DEPTH: Final = 0.75
"""Of the first swing, as a share of the pressure: more than what seals and ball can hold."""
_TIMES: Final = 12
"""How often they swing, each time less by as much."""


class Tug(NamedTuple):
    """One tug.

    Parameters
    ----------
    name : str
        Of its stretch.
    pair : int
        0 or 1.
    side : int
        +1 or -1: where to.
    swing : int
        +1 or -1: whether the pressures rise or fall first.
    after : int
        The tug before: `SAME`, `BACK` or `OTHER`.
    start : float
        When the ring begins to go upright, s.
    rise : float
        When the force begins to rise, s.
    end : float
        s.
    """

    name: str
    pair: int
    side: int
    swing: int
    after: int
    start: float
    rise: float
    end: float


@dataclass(frozen=True, slots=True)
class StrokesAndTugs:
    """Strokes that lean between a joint's pairs, and then tugs at each of them to either side.

    Parameters
    ----------
    strokes : Strokes or Slides
        Of what lies along the ball; slides where no law leads the ring along it.
    rounds : int
        Of tugs, `PER_ROUND` at each pair to each side; 0 for none.
    rate : float
        Of the force, N/s.
    most : float
        Greatest force, N.
    move, shake, rest : float
        Time to go upright, for the pressures to swing there, and to rest, s.
    """

    strokes: Strokes | Slides
    rounds: Annotated[int, Ge(0)] = 1
    rate: Annotated[float, Unit("N/s"), Gt(0)] = 20.0
    most: Annotated[float, Unit("N"), Gt(0)] = 32.0
    move: Annotated[float, Unit("s"), Gt(0)] = 0.8
    shake: Annotated[float, Unit("s"), Gt(0)] = 2.4
    rest: Annotated[float, Unit("s"), Gt(0)] = 0.3
    _tugs: tuple[Tug, ...] = field(init=False, repr=False, default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "_tugs", tuple(self._plan()))

    def _plan(self) -> Iterator[Tug]:
        before = self.move + self.shake + self.rest
        each = before + self.most / self.rate
        last = _KINDS[_ROUND[-1]]
        for k, (kind, swing) in enumerate((*zip(_ROUND, _SWINGS, strict=True),) * self.rounds):
            pair, side = _KINDS[kind]
            after = OTHER if pair != last[0] else SAME if side == last[1] else BACK
            last = pair, side
            start = self.strokes.duration + k * each
            name = f"tug {k + 1} at pair {pair + 1} {'+' if side > 0 else '-'}"
            yield Tug(name, pair, side, swing, after, start, start + before, start + each)

    def swung(self, tug: Tug, t: float) -> float:
        """Return the pressures over those of rest at time `t` (s)."""
        passed = (t - tug.start - self.move) / self.shake
        if not 0.0 < passed < 1.0:
            return 1.0
        swing = math.sin(2.0 * math.pi * _TIMES * passed)
        return 1.0 + DEPTH * tug.swing * (1.0 - passed) * swing

    @property
    def tugs(self) -> tuple[Tug, ...]:
        """The tugs in their order."""
        return self._tugs

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._tugs[-1].end if self._tugs else self.strokes.duration

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The strokes' constant-speed parts, and each tug from where its force begins to rise."""
        rises = (Segment(tug.name, tug.rise, tug.end) for tug in self._tugs)
        return (*self.strokes.segments, *rises)


class TugScript(GuidedScript[JointReference, JointState, JointCommand], PosedMotion):
    """Does strokes under a controller, and tugs that it catches.

    Parameters
    ----------
    settings : StrokesAndTugs
        What is to be done.
    strokes : PosedMotion
        The strokes as a motion of the joint.
    controller : EstimatingController
        Follows it, and catches the ring.
    base : float
        Co-contraction of the tugs, Pa gauge.
    calm : float
        The same wherever the controller has the ring, Pa gauge.
    give : float
        How far a pair moves on its wires for each newton that pushes it, m/N.
    """

    estimate: JointEstimate

    def __init__(
        self,
        settings: StrokesAndTugs,
        strokes: PosedMotion,
        controller: EstimatingController[JointReference, JointState, JointCommand],
        base: float,
        calm: float,
        give: float = 0.0,
    ) -> None:
        super().__init__(settings.duration, settings.segments, controller)
        self._settings = settings
        self._strokes = strokes
        self._base, self._calm, self._give = base, calm, give

    @property
    def pose(self) -> tuple[float, float, float]:
        """What a joint's log keeps of a plan."""
        return self._strokes.pose

    def describe(self) -> Iterator[str]:
        """Yield what comes after the strokes."""
        settings = self._settings
        force, rate = format_quantity(settings.most, "N"), format_quantity(settings.rate, "N/s")
        base, top = (format_quantity(share * self._base, "Pa") for share in (1.0, 1.0 + DEPTH))
        count = len(settings.tugs)
        yield f"then upright, at {base}: {count} times one pair is pushed until it moves,"
        yield f"no controller holding it, with a force that rises by {rate}, up to {force}"
        yield f"before each of them all four pressures swing, up to {top} and ever less"

    def reference_at(self, t: float) -> JointReference:
        """Return the strokes' reference, and of tugs that to stand upright."""
        if t < self._settings.strokes.duration:
            return self._strokes.at(t)
        return JointReference(_UPRIGHT, _ZERO, _ZERO, base_pressure=self._calm)

    def play(self) -> Iterator[JointCommand]:
        """Do the strokes; for each tug go upright, swing and push, and catch the ring."""
        yield from self._begin()
        for tug in self._settings.tugs:
            yield from self._place_for(tug)
            stood, force = self._place(tug), 0.0
            while self._is_at(tug):
                if self.t < tug.rise:
                    stood = self._place(tug)
                force = self._settings.rate * max(self.t - tug.rise, 0.0)
                gone = tug.side * (self._place(tug) - stood)
                if gone >= self._broken(force) or force >= self._settings.most:
                    break
                yield self._push(tug, force)
            yield from self._catch(tug, force)

    def _begin(self) -> Iterator[JointCommand]:
        """Do what comes before the tugs."""
        tugs = self._settings.tugs
        while not tugs or self.t < tugs[0].start:
            yield self.follow(self.wanted)

    def _place_for(self, tug: Tug) -> Iterator[JointCommand]:
        """Have the ring upright before a tug."""
        leant, moving = self._axis(), tug.start + self._settings.move
        while self.t < moving:
            yield self._go_upright(leant, tug.start)

    def _catch(self, tug: Tug, force: float) -> Iterator[JointCommand]:
        """Have the ring stop after a tug, which has pushed it with a force (N)."""
        leant, caught = self._axis(), self.t
        while self._is_at(tug):
            yield self._go_upright(leant, caught)

    def _broken(self, force: float) -> float:
        """Return how far a pair has gone that has broken away under a force (N), m."""
        return BROKEN + self._give * force

    def _is_at(self, tug: Tug) -> bool:
        return self.t < tug.end or tug is self._settings.tugs[-1]

    def _axis(self) -> Vector:
        """Return where the ring points by the rods."""
        x, y, z = self.estimate.encoder_marker
        length = math.sqrt(x * x + y * y + z * z)
        if length == 0.0:  # nobody has looked yet: it begins at home
            return _UPRIGHT
        return (x / length, y / length, z / length)

    def _place(self, tug: Tug) -> float:
        """Return where the pair of a tug is, m."""
        return self._place_of(tug.pair)

    def _place_of(self, pair: int) -> float:
        """Return where a pair is, m."""
        a, b, c, d = self.state.rods
        return 0.5 * (a - c) if pair == 0 else 0.5 * (d - b)

    def _go_upright(self, leant: Vector, since: float) -> JointCommand:
        way = great_circle(leant, _UPRIGHT, 0.8 * self._settings.move, self.t - since)
        return self.follow(way._replace(base_pressure=self._calm))

    def _push(self, tug: Tug, force: float) -> JointCommand:
        push = (tug.side * force, 0.0) if tug.pair == 0 else (0.0, tug.side * force)
        base = self._base * self._settings.swung(tug, self.t)
        return self.follow(JointReference(_UPRIGHT, _ZERO, _ZERO, base_pressure=base, push=push))
