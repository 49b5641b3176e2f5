"""Moves of servo axes from posture to posture."""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Protocol, TypeVar

from annotated_types import Gt, MinLen, Unit

from controllers.minimum_jerk import minimum_jerk
from rig.calibration.sequence import ScriptedMotion
from rig.config import format_quantity
from rig.hal import LimitExceeded
from rig.hal.motion import Segment

Posture = tuple[float, ...]


class AxisPositions(Protocol):
    """Positions of axes."""

    @property
    def positions(self) -> Posture:
        """Rad."""


class AxisMotion(AxisPositions, Protocol):
    """Positions and velocities that axes should have."""

    @property
    def velocities(self) -> Posture:
        """rad/s."""


Reference = TypeVar("Reference", bound=AxisMotion)
Command = TypeVar("Command")

_STEP = 0.01
"""The motion is looked at every so often for the preview, s."""

_PEAK = 1.875
"""Of the speed of a minimum-jerk move over its mean."""

_LEAST = 0.4
"""Duration of the shortest move, s."""


@dataclass(frozen=True, slots=True)
class Postures:
    """Postures one after the other.

    Parameters
    ----------
    names : tuple of str
        Of the postures; one without a name is passed and not judged.
    joints : tuple of str
        Of the axes.
    angles : tuple of tuple of float
        Of every axis in every posture, rad.
    dwell : float
        Time in each posture that has a name, s.
    judged : float
        So much of its end is judged, s.
    relative : bool
        Angles count from where the axes stand at the start.
    """

    names: Annotated[tuple[str, ...], MinLen(1)]
    joints: tuple[str, ...]
    angles: tuple[tuple[Annotated[float, Unit("rad")], ...], ...]
    dwell: Annotated[float, Unit("s"), Gt(0)]
    judged: Annotated[float, Unit("s"), Gt(0)]
    relative: bool = False


class PostureScript(ScriptedMotion[Reference, AxisPositions, Command]):
    """Goes through postures by minimum-jerk moves, each as fast as its slowest axis may.

    Parameters
    ----------
    settings : Postures
        Where to, and for how long.
    speeds : sequence of float
        That no axis exceeds, rad/s.
    limits : sequence of tuple of float
        Of each axis, rad; a motion from where the axes stand is refused if it leaves them.
    reference, command : callable
        The mechanism's, of positions, velocities (and whether a law follows a path: never).
    has_torque : bool
        Without it nobody moves: the drives are only listened to.
    """

    waits = True
    """A late cycle holds the motion."""

    def __init__(
        self,
        settings: Postures,
        speeds: Sequence[float],
        limits: Sequence[tuple[float, float]],
        *,
        reference: Callable[..., Reference],
        command: Callable[..., Command],
        has_torque: bool = True,
    ) -> None:
        self.settings = settings
        self.has_torque = has_torque
        self._reference, self._command = reference, command
        self._limits = tuple(limits)
        self._still = (0.0,) * len(self._limits)
        self._origin: Posture = self._still
        # Each move and the dwell after it: start, duration of the move, from where.
        self._starts: list[float] = []
        self._moves: list[tuple[float, Posture]] = []
        segments, here, t = [], settings.angles[0], 0.0
        for name, there in zip(settings.names, settings.angles, strict=True):
            duration = max(
                _PEAK * abs(b - a) / speed for a, b, speed in zip(here, there, speeds, strict=True)
            )
            duration = max(duration, _LEAST) if duration > 0.0 else 0.0
            self._starts.append(t)
            self._moves.append((duration, here))
            t += duration + (settings.dwell if name else 0.0)
            if name:
                segments.append(Segment(name, t - settings.judged, t))
            here = there
        # The loop stops at its duration: the last segment is to be there as a whole.
        super().__init__(t + 0.1, segments)

    def describe(self) -> Iterator[str]:
        """Yield how far each axis goes, and how fast."""
        settings = self.settings
        if not self.has_torque:
            yield "no torque: the joints are moved by hand, and nothing moves by itself"
            return
        rows = [self.at(k * _STEP).velocities for k in range(int(self.duration / _STEP))]
        where = " from where it stands" if settings.relative else ""
        for name, angles, speeds in zip(
            settings.joints, zip(*settings.angles, strict=True), zip(*rows, strict=True),
            strict=True,
        ):  # fmt: skip
            low, high = format_quantity(min(angles), "rad"), format_quantity(max(angles), "rad")
            speed = format_quantity(max(map(abs, speeds)), "rad/s")
            yield f"{name} moves {low} … {high}{where}, up to {speed}"

    def reference_at(self, t: float) -> Reference:
        """Return where the axes should be at `t`."""
        k = max(bisect_right(self._starts, t) - 1, 0)
        duration, before = self._moves[k]
        there = self.settings.angles[k]
        passed = t - self._starts[k]
        if passed >= duration:
            return self._reference(self._from_origin(there), self._still, False)
        ways = [
            minimum_jerk(a, b, duration, max(passed, 0.0))
            for a, b in zip(before, there, strict=True)
        ]
        here = self._from_origin(tuple([way[0] for way in ways]))
        return self._reference(here, tuple([way[1] for way in ways]), False)

    def reset(self, state: AxisPositions) -> None:
        """Start from where the axes stand, if the postures count from there.

        Raises
        ------
        LimitExceeded
            An axis would leave its limits.
        """
        super().reset(state)
        if not self.settings.relative:
            return
        for k, (low, high) in enumerate(self._limits):
            reach = [posture[k] for posture in self.settings.angles]
            for end in (min(reach), max(reach)):
                if self.has_torque and not low <= state.positions[k] + end <= high:
                    raise LimitExceeded(
                        f"where {self.settings.joints[k]} would go from where it stands",
                        state.positions[k] + end, low, high, "rad",
                    )  # fmt: skip
        self._origin = state.positions

    def play(self) -> Iterator[Command]:
        """Yield the command to be where the reference is."""
        while True:
            yield self._command(self.wanted.positions, self.wanted.velocities)

    def _from_origin(self, angles: Posture) -> Posture:
        return tuple([a + b for a, b in zip(self._origin, angles, strict=True)])
