"""What scripted motions have in common: their length and stretches are known when they are made."""

from collections.abc import Sequence
from typing import TypeVar

from rig.hal.motion import Motion, Segment

Followed = TypeVar("Followed", covariant=True)


class ScriptedMotion(Motion[Followed]):
    """A motion that is written down beforehand, stretch by stretch.

    Parameters
    ----------
    duration : float
        s.
    segments : sequence of Segment
        What is recorded of it.
    """

    def __init__(self, duration: float, segments: Sequence[Segment]) -> None:
        self._duration = float(duration)
        self._segments = tuple(segments)

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._duration

    @property
    def segments(self) -> tuple[Segment, ...]:
        """What is recorded of it."""
        return self._segments
