"""Joint moves from posture to posture; to the runtime they are motion and controller in one."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from annotated_types import Gt, MinLen, Unit

from controllers.minimum_jerk import minimum_jerk
from rig.calibration.sequence import ScriptedMotion
from rig.hal import LimitExceeded
from rig.hal.motion import Segment

Posture = tuple[float, ...]

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
        Of the joints.
    angles : tuple of tuple of float
        Of every joint in every posture, rad.
    dwell : float
        Time in each posture that has a name, s.
    judged : float
        So much of its end is judged, s.
    relative : bool
        Angles count from where the joints stand at the start.
    """

    names: Annotated[tuple[str, ...], MinLen(1)]
    joints: tuple[str, ...]
    angles: tuple[tuple[Annotated[float, Unit("rad")], ...], ...]
    dwell: Annotated[float, Unit("s"), Gt(0)]
    judged: Annotated[float, Unit("s"), Gt(0)]
    relative: bool = False


class PostureMoves(ScriptedMotion[Any]):
    """Goes through postures by minimum-jerk moves, each as fast as its slowest joint may.

    Parameters
    ----------
    settings : Postures
        Where to, and for how long.
    speeds : sequence of float
        That no joint exceeds, rad/s.
    limits : sequence of tuple of float
        Of each joint, rad; a motion from where the joints stand is refused if it leaves them.
    reference, command : callable
        The mechanism's, of positions, velocities (and whether a law follows a path: never).
    columns : int
        How many columns of a plan the mechanism's log has.
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
        reference: Callable[..., Any],
        command: Callable[..., Any],
        columns: int,
        has_torque: bool = True,
    ) -> None:
        self.settings = settings
        self.has_torque = has_torque
        self._reference, self._command = reference, command
        self._row = (0.0,) * columns
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

    def at(self, t: float) -> Any:
        """Return where the joints should be at `t`."""
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

    def sample(self, number: int) -> tuple[float, ...]:
        """Return the plan's columns: there is no plan."""
        return self._row

    def reset(self, state: Any) -> None:
        """Start from where the joints stand, if the postures count from there.

        Raises
        ------
        LimitExceeded
            A joint would leave its limits.
        """
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

    def update(self, state: Any, reference: Any) -> Any:
        """Return the command to be where the reference is."""
        return self._command(reference.positions, reference.velocities)

    def _from_origin(self, angles: Posture) -> Posture:
        return tuple([a + b for a, b in zip(self._origin, angles, strict=True)])
