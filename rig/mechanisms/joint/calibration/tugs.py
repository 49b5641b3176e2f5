"""Tugs at a joint's pairs that stand still: how much it takes until one breaks away.

Creeping under a controller, both pairs slip by turns, and what each of them shows then depends on
where the other has left the ring's seat. So the ring stands upright, where nothing makes it fall
over, one pair is pushed ever harder while the other one holds, and a controller catches the ring
as soon as it has moved.

What the tug before has left in the contacts shows in what a tug takes. Most of it is tension that
seals and ball hold in both wires of a pair, up to 10 N more or less than their chambers pull: it
loads the ring's seat, and no monitor sees it. So all four pressures swing around those of rest
before each tug, ever less. Of each kind as many begin with a rise as with a fall, and each kind
follows each equally often, so that what is left after all is not in their mean.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated, Any, Final, NamedTuple

from annotated_types import Ge, Gt, Unit

from controllers.spherical_joint.great_circle import great_circle
from controllers.spherical_joint.types import JointCommand, JointReference, JointState
from rig.calibration.sequence import ScriptedMotion
from rig.hal.motion import Segment
from rig.mechanisms.joint.motion import PosedMotion
from rig.mechanisms.pneumatic.calibration.pressure_steps import Strokes

_UPRIGHT: Final = (0.0, 0.0, 1.0)
_ZERO: Final = (0.0, 0.0, 0.0)
_KINDS: Final = ((0, 1), (0, -1), (1, 1), (1, -1))
"""Pair and side."""
_ROUND: Final = (0, 0, 1, 0, 2, 0, 3, 1, 1, 2, 1, 3, 2, 2, 3, 3)
"""A de Bruijn sequence: round and round, each kind follows each once."""
_SWINGS: Final = (1, -1, -1, 1, 1, -1, 1, 1, 1, -1, -1, -1, 1, -1, -1, 1)
"""Whether pressures rise or fall first: as often of each kind, and after each kind of each pair."""
SAME, BACK, OTHER = range(3)
"""A tug follows one of its own kind, one at its pair to the other side, one at the other pair."""

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
        What the tug before was: `SAME`, `BACK` or `OTHER`.
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
    strokes : Strokes
        Of what lies along the ball.
    rounds : int
        Of tugs, `PER_ROUND` at each pair to each side; 0 for none.
    rate : float
        Of the force, N/s.
    most : float
        Greatest force, N.
    move, shake, rest : float
        Time to go upright, for the pressures to swing there, and to rest, s.
    """

    strokes: Strokes
    rounds: Annotated[int, Ge(0)] = 1
    rate: Annotated[float, Unit("N/s"), Gt(0)] = 20.0
    most: Annotated[float, Unit("N"), Gt(0)] = 32.0
    move: Annotated[float, Unit("s"), Gt(0)] = 0.8
    shake: Annotated[float, Unit("s"), Gt(0)] = 2.4
    rest: Annotated[float, Unit("s"), Gt(0)] = 0.3
    _tugs: Any = field(init=False, repr=False, default=())

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
        return tuple(self._tugs)

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self._tugs[-1].end if self._tugs else self.strokes.duration)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The strokes' constant-speed parts, and each tug from where its force begins to rise."""
        rises = (Segment(tug.name, tug.rise, tug.end) for tug in self._tugs)
        return (*self.strokes.segments, *rises)


class Tugging(ScriptedMotion[JointReference], PosedMotion):
    """Does strokes and tugs; to the runtime it is the motion and its controller in one.

    Parameters
    ----------
    settings : StrokesAndTugs
        What is to be done.
    strokes : Motion
        The strokes as a motion of the joint.
    controller : PoseController
        Follows it, and catches the ring.
    base : float
        Co-contraction of the tugs, Pa gauge.
    calm : float
        The same wherever the controller has the ring, Pa gauge.
    """

    def __init__(
        self, settings: StrokesAndTugs, strokes: Any, controller: Any, base: float, calm: float
    ) -> None:
        ScriptedMotion.__init__(self, settings.duration, settings.segments)
        self.estimate = controller.estimate
        self.learning = None  # what the joint's log keeps of laps
        self.settings = settings
        self._strokes = strokes
        self._controller = controller
        self.base = base
        self._calm = calm
        self._t = 0.0
        self._restart()

    def _restart(self) -> None:
        self._number = -1
        self._from = _UPRIGHT
        self._since = 0.0
        self._stood: float | None = None
        self._caught = False

    @property
    def pose(self) -> Any:
        """What a joint's log keeps of a plan."""
        return self._strokes.pose

    def at(self, t: float) -> JointReference:
        """Take the time, and return the reference: of tugs that to stand upright."""
        self._t = t
        if t < self.settings.strokes.duration:
            reference: JointReference = self._strokes.at(t)
            return reference
        return JointReference(_UPRIGHT, _ZERO, _ZERO, base_pressure=self._calm)

    def reset(self, state: JointState) -> None:
        """Start over."""
        self._restart()
        self._controller.reset(state)

    def update(self, state: JointState, reference: JointReference) -> JointCommand:
        """Return the command of this instant."""
        tug = self._tug_at(self._t)
        if tug is not None:
            reference = self._during(tug, state)
        command: JointCommand = self._controller.update(state, reference)
        self.estimate = self._controller.estimate
        return command

    def _tug_at(self, t: float) -> Tug | None:
        tugs = self.settings.tugs
        if not tugs or t < tugs[0].start:
            return None
        while self._number < 0 or (t >= tugs[self._number].end and self._number < len(tugs) - 1):
            self._number += 1
            self._leave(tugs[self._number].start)
        return tugs[self._number]

    def _leave(self, t: float) -> None:
        """Go upright from here on."""
        x, y, z = self.estimate.encoder_marker
        length = math.sqrt(x * x + y * y + z * z)
        self._from = (x / length, y / length, z / length)
        self._since = t
        self._stood, self._caught = None, False

    def _during(self, tug: Tug, state: JointState) -> JointReference:
        """Return what the controller is asked for in a tug: to stand, to push or to catch."""
        t, (a, b, c, d) = self._t, state.rods
        place = 0.5 * (a - c) if tug.pair == 0 else 0.5 * (d - b)
        if t >= tug.start + self.settings.move and not self._caught:
            if t < tug.rise or self._stood is None:
                self._stood = place
            force = self.settings.rate * max(t - tug.rise, 0.0)
            if tug.side * (place - self._stood) < BROKEN and force < self.settings.most:
                push = (tug.side * force, 0.0) if tug.pair == 0 else (0.0, tug.side * force)
                base = self.base * self.settings.swung(tug, t)
                return JointReference(_UPRIGHT, _ZERO, _ZERO, base_pressure=base, push=push)
            self._leave(t)
            self._caught = True
        back = great_circle(self._from, _UPRIGHT, 0.8 * self.settings.move, t - self._since)
        return back._replace(base_pressure=self._calm)
