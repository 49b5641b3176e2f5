"""Scripted motions: stretches that a procedure plays one after the other."""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import Protocol, TypeVar

from rig.hal.controller import Controller
from rig.hal.motion import Motion, Segment

State = TypeVar("State")
Reference = TypeVar("Reference")
Command = TypeVar("Command")
_State = TypeVar("_State", contravariant=True)
_Reference = TypeVar("_Reference", contravariant=True)
_Command = TypeVar("_Command", covariant=True)


class EstimatingController(
    Controller[_Reference, _State, _Command], Protocol[_Reference, _State, _Command]
):
    """A controller that shows what it believes, for the log."""

    @property
    def estimate(self) -> object:
        """What it believes."""


class ScriptedMotion(Motion[Reference], Controller[Reference, State, Command]):
    """A motion that is its own controller.

    The runtime asks the motion for each instant right before it updates the controller, so the
    script always knows the time `t`, and in `update` also the `state` and the `wanted` reference.
    A subclass tells in `play` what happens, stretch by stretch; each ``yield`` is one cycle.

    Parameters
    ----------
    duration : float
        s.
    segments : sequence of Segment
        What is recorded of it.
    """

    t: float = 0.0
    state: State
    wanted: Reference

    estimate: object = None
    """What the log keeps of a controller's beliefs."""

    learning: None = None
    """What the log keeps of learning over laps; there is none."""

    def __init__(self, duration: float, segments: Sequence[Segment]) -> None:
        self._duration = float(duration)
        self._segments = tuple(segments)
        self._played = self.play()

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._duration

    @property
    def segments(self) -> tuple[Segment, ...]:
        """What is recorded of it."""
        return self._segments

    @abstractmethod
    def describe(self) -> Iterator[str]:
        """Yield what it moves and how far, a sentence each."""

    @abstractmethod
    def reference_at(self, t: float) -> Reference:
        """Return the reference at `t`: what comes can only be planned as far as that."""

    @abstractmethod
    def play(self) -> Iterator[Command]:
        """Yield the command of each cycle, without end."""

    def at(self, t: float) -> Reference:
        """Take the time, and return the reference."""
        self.t = t
        return self.reference_at(t)

    def compile(self) -> None:
        """Do nothing: whoever follows for it is compiled."""

    def reset(self, state: State) -> None:
        """Start over."""
        self._played = self.play()

    def update(self, state: State, reference: Reference) -> Command:
        """Return the command of this instant."""
        self.state, self.wanted = state, reference
        return next(self._played)


class GuidedScript(ScriptedMotion[Reference, State, Command]):
    """A script that leaves some of its stretches to a controller.

    Parameters
    ----------
    duration, segments
        See `ScriptedMotion`.
    controller : EstimatingController
        Who follows in those stretches.
    """

    def __init__(
        self,
        duration: float,
        segments: Sequence[Segment],
        controller: EstimatingController[Reference, State, Command],
    ) -> None:
        self.estimate = controller.estimate
        self.controller = controller
        super().__init__(duration, segments)

    def reset(self, state: State) -> None:
        """Start over."""
        super().reset(state)
        self.controller.reset(state)

    def follow(self, reference: Reference) -> Command:
        """Return what the controller makes of a reference in this cycle."""
        command = self.controller.update(self.state, reference)
        self.estimate = self.controller.estimate
        return command


def between(start: Sequence[float], goal: Sequence[float], share: float) -> tuple[float, ...]:
    """Return what lies a share of the way from one to the other; from 1 on the other."""
    if share >= 1.0:
        return tuple(goal)
    return tuple(a + share * (b - a) for a, b in zip(start, goal, strict=True))
