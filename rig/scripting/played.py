"""A plan written in Python, as the loop follows it."""

import traceback
from bisect import bisect_right
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextvars import ContextVar
from itertools import pairwise
from types import GeneratorType
from typing import NamedTuple, TypeAlias

from rig.hal import ConfigurationError, Device, RigError, SafetyError
from rig.hal.motion import Motion, Note, Segment
from rig.hal.targets import Targets
from rig.scripting.steps import PlanFailed, PlanStep, Steps

PlanFunction: TypeAlias = Callable[[Steps], Generator[PlanStep, bool, None]]
"""``def plan(rig): yield rig.move(…)``."""

_WHENCE = "as its argument's move(…) and the like return"


_asked: ContextVar[str | None] = ContextVar("asked", default=None)
"""The plan that is asked for its next step at this moment."""


def refuse_within_plan(what: str) -> None:
    """Refuse what would begin a run in the midst of another.

    Raises
    ------
    ConfigurationError
        A plan calls it.
    """
    plan = _asked.get()
    if plan is not None:
        raise ConfigurationError(
            f"{what} within the plan {plan}: its own run goes on meanwhile; yield steps, and call "
            f"{what} after that run"
        )


class PlanRefused(SafetyError):
    """A plan cannot go on: the rig is made safe. It names the plan, the line and the reason."""


class _Played(NamedTuple):
    """A step that was done or is being done, and when it began and ended, s."""

    start: float
    end: float
    step: PlanStep

    def at(self, t: float) -> object:
        """Return the reference; beyond its ends the step rests there."""
        return self.step.path(min(max(t - self.start, 0.0), self.step.duration))


class Foreseen(Motion[object]):
    """A plan as its rehearsal went."""

    def __init__(self, played: Sequence[_Played], segments: Sequence[Segment]) -> None:
        self._played = tuple(played)
        self._starts = [one.start for one in played]
        self._segments = tuple(segments)

    @property
    def duration(self) -> float:
        """How long it took, s."""
        return self._played[-1].end

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Its marks, and the whole of it."""
        return self._segments

    def at(self, t: float) -> object:
        """Return the reference at `t`."""
        return self._played[max(bisect_right(self._starts, t) - 1, 0)].at(t)


class PlayedPlan(Motion[object]):
    """Plays a plan: each step begins when the one before is over, and was checked before.

    Parameters
    ----------
    play : PlanFunction
        The plan.
    targets, approach, start
        See `Steps`.
    most : float
        A plan that takes longer is a fault, s.
    rehearsing : bool
        Whether this is the rehearsal.

    Attributes
    ----------
    known : PlayedPlan or None
        Its rehearsal. A step that did not come there is checked for one instant per cycle, and
        the rig waits for it; without a rehearsal it is checked in one cycle, which is for
        simulated time.
    """

    watches = True
    waits = True
    """A late cycle holds the plan: nothing of it is left out."""

    def __init__(
        self,
        play: PlanFunction,
        targets: Targets[object],
        approach: Callable[[object, object, float, float], object],
        start: object,
        *,
        most: float,
        rehearsing: bool = False,
    ) -> None:
        self.name = getattr(play, "__name__", type(play).__name__)
        self.known: PlayedPlan | None = None
        self._play = play
        self._targets = targets
        self._most = most
        self._checked: set[str] = set()
        self._steps = Steps(targets, approach, start, rehearsing=rehearsing)
        self._playing: Generator[PlanStep, bool, None] | None = None
        self._done: list[_Played] = []
        self._start = PlanStep(lambda _: start, 0.0, "start")
        self._now = _Played(0.0, 0.0, self._start)
        self._next: tuple[PlanStep, Iterator[float]] | None = None
        self._ended = False

    @property
    def duration(self) -> float:
        """How long it took, s; while it goes on, how long it may take."""
        return self._now.end if self._ended else self._most

    @property
    def segments(self) -> tuple[Segment, ...]:
        """From each mark to the next, and the whole of it, ``"all"``."""
        end = self._now.end if self._ended else self._steps.t
        if self.known is not None and self._playing is None:
            return self.known.segments
        marks = [*self._steps.marks, (end, "")]
        named = [
            Segment(name, start, until)
            for (start, name), (until, _) in pairwise(marks)
            if until > start
        ]
        return (Segment("all", 0.0, end), *named)

    @property
    def foreseen(self) -> Motion[object]:
        """The plan as its rehearsal went; before one, as it went so far."""
        source = self.known or self
        return Foreseen([*source._done, source._now], source.segments)

    def attach(self, devices: Mapping[str, Device]) -> None:
        """Take the rig's devices, for readings of their own."""
        self._steps.devices = dict(devices)

    def at(self, t: float) -> object:
        """Return the reference of the step at hand."""
        return self._now.at(t)

    def see(self, t: float, state: object, here: object) -> Sequence[Note]:
        """Take what was measured, and go on to the next step if this one is over."""
        steps = self._steps
        steps.t, steps.state = t, state
        if self._ended:
            return ()
        if t >= self._most:
            raise PlanRefused(f"the plan {self.name} takes longer than {self._most:g} s")
        token = _asked.set(self.name)
        try:
            if self._next is not None:
                self._check(t)
            elif self._playing is None:
                self._playing = self._begin()
                self._advance(t, None)
            else:
                self._go_on(t, here)
        except PlanRefused:
            raise
        except (Exception, SystemExit) as error:  # sys.exit() must not end it with the rig moving
            raise PlanRefused(f"the plan {self.name}{self._line(error)}: {_said(error)}") from error
        finally:
            _asked.reset(token)
        notes, steps.notes = tuple(steps.notes), []
        return notes

    def _begin(self) -> Generator[PlanStep, bool, None]:
        playing = self._play(self._steps)
        if not isinstance(playing, GeneratorType):
            raise PlanFailed(f"it returns {playing!r}; a plan yields steps, {_WHENCE}")
        return playing

    def _go_on(self, t: float, here: object) -> None:
        start, _, step = self._now
        until = step.until
        reached = until is not None and until(t - start, here)
        if reached or t - start >= step.duration:
            self._now = _Played(start, t, step)
            self._advance(t, reached if until is not None else None)

    def _advance(self, t: float, answer: bool | None) -> None:
        """Ask the plan for its next step, and begin it or have it checked first."""
        assert self._playing is not None
        try:
            step = next(self._playing) if answer is None else self._playing.send(answer)
        except StopIteration:
            if self._now.step is self._start:
                raise PlanFailed("it has no step") from None
            self._ended = True
            self._now = self._now._replace(end=t)
            return
        if not isinstance(step, PlanStep):
            raise PlanFailed(f"it yields {step!r}, which is no step, {_WHENCE}")
        self._next = (step, step.instants())
        self._check(t)

    def _check(self, t: float) -> None:
        """Check the next step, all of it or the next instant; begin it once it is checked."""
        assert self._next is not None
        step, instants = self._next
        if self.known is None:
            for instant in instants:
                self._targets.check(step.path(instant))
        elif _mark_of(step) not in self.known._checked:
            for instant in instants:
                self._targets.check(step.path(instant))
                return
        self._checked.add(_mark_of(step))
        self._next = None
        if self._now.step is not self._start:
            self._done.append(self._now)
        self._now = _Played(t, t + step.duration, step)
        self._steps.notes.append(Note("plan", step.what))

    def _line(self, error: BaseException) -> str:
        """Return the line of the plan that asked for it."""
        playing = self._playing
        frame = playing.gi_frame if isinstance(playing, GeneratorType) else None
        if frame is not None:
            return f", line {frame.f_lineno}"
        code = getattr(self._play, "__code__", None)
        for entry in reversed(traceback.extract_tb(error.__traceback__)):
            if code is not None and entry.filename == code.co_filename:
                return f", line {entry.lineno}"
        return ""


def _mark_of(step: PlanStep) -> str:
    """Return what tells a step from others: its words, and some places of its path."""
    places = [step.path(share * step.duration) for share in (0.0, 0.13, 0.37, 0.59, 0.83, 1.0)]
    return f"{step.what} {places}"


def _said(error: BaseException) -> str:
    if isinstance(error, SystemExit):
        return f"it wants to end the program ({type(error).__name__}: {error})"
    plain = isinstance(error, PlanFailed | RigError | ValueError)
    return str(error) if plain else f"{type(error).__name__}: {error}"
