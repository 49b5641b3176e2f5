"""Excitations: pressures without a loop around them, and what they look like to the runtime."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Generic, TypeVar

from annotated_types import Gt, MinLen, Unit

from controllers.spherical_joint.types import JointReference
from rig.calibration.sequence import ScriptedMotion
from rig.hal.motion import Motion, Segment
from rig.mechanisms.joint.motion import JointDrawing

Reference = TypeVar("Reference")
Command = TypeVar("Command")


@dataclass(frozen=True, slots=True)
class PressureSteps:
    """Pressures one after the other, the same in every channel.

    Parameters
    ----------
    names : tuple of str
        Of the steps.
    pressures : tuple of float
        Setpoint of each, Pa gauge.
    ramp : float
        Time in which a step is reached, s.
    dwell : float
        Time on it, s.
    judged : float
        So much of the end of each dwell is judged, s.
    """

    names: Annotated[tuple[str, ...], MinLen(1)]
    pressures: Annotated[tuple[Annotated[float, Unit("Pa")], ...], MinLen(1)]
    ramp: Annotated[float, Unit("s"), Gt(0)] = 0.3
    dwell: Annotated[float, Unit("s"), Gt(0)] = 1.5
    judged: Annotated[float, Unit("s"), Gt(0)] = 0.5

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return len(self.names) * (self.ramp + self.dwell)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The judged end of each dwell; steps without a name are passed and not judged."""
        each = self.ramp + self.dwell
        return tuple(
            Segment(name, (k + 1) * each - self.judged, (k + 1) * each)
            for k, name in enumerate(self.names)
            if name
        )

    def knots(self, start: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return times and pressures between which setpoints run straight."""
        each = self.ramp + self.dwell
        times, pressures = [0.0], [start]
        for k, pressure in enumerate(self.pressures):
            times += [k * each + self.ramp, (k + 1) * each]
            pressures += [pressure, pressure]
        return tuple(times), tuple(pressures)


class OpenLoop(ScriptedMotion[Reference], Generic[Reference, Command]):
    """Gives pressures by the clock; to the runtime it is the motion and its controller in one.

    The runtime asks the motion for each instant right before it updates the controller, so the
    controller knows the instant from the motion.

    Parameters
    ----------
    times : sequence of float
        s.
    pressures : sequence of sequence of float
        Of every channel at those times, Pa gauge; straight between.
    segments : sequence of Segment
        Stretches to be judged.
    rest : Reference
        The mechanism's reference to stay where it is.
    command : callable
        Makes the mechanism's command of one pressure per channel.
    estimate : object
        What a controller of this mechanism shows of its beliefs; this one has none.
    """

    def __init__(
        self,
        times: Sequence[float],
        pressures: Sequence[Sequence[float]],
        segments: Sequence[Segment],
        *,
        rest: Reference,
        command: Any,
        estimate: Any,
    ) -> None:
        self.times = tuple(times)
        self.pressures = tuple(tuple(row) for row in pressures)
        super().__init__(self.times[-1], segments)
        self.estimate = estimate
        # What the joint's log keeps of learning; there is none.
        self.learning = None
        self._rest = rest
        self._command = command
        self._t = 0.0

    def at(self, t: float) -> Reference:
        """Take the time, and return the reference to stay."""
        self._t = t
        return self._rest

    def reset(self, state: Any) -> None:
        """Start over; there is nothing to remember."""
        self._t = 0.0

    def update(self, state: Any, reference: Any) -> Command:
        """Return the pressures of this instant."""
        command: Command = self._command(*self.at_time(self._t))
        return command

    def at_time(self, t: float) -> tuple[float, ...]:
        """Return the pressures at an instant, Pa gauge."""
        times = self.times
        k = min(max(bisect_right(times, t), 1), len(times) - 1)
        start, end = times[k - 1], times[k]
        share = 1.0 if end <= start else min(max((t - start) / (end - start), 0.0), 1.0)
        return tuple(
            a + share * (b - a)
            for a, b in zip(self.pressures[k - 1], self.pressures[k], strict=True)
        )


@dataclass(frozen=True, slots=True)
class Strokes(Motion[Any]):
    """Constant-speed strokes to and fro, each with a name of its own.

    Parameters
    ----------
    travel : float
        Half a stroke, m.
    speeds : tuple of float
        One stroke to and one fro at each, m/s; a speed may come more than once.
    turn : float
        Time in which a stroke starts and ends, s.
    """

    travel: Annotated[float, Unit("m"), Gt(0)]
    speeds: Annotated[tuple[Annotated[float, Unit("m/s"), Gt(0)], ...], MinLen(1)]
    turn: Annotated[float, Unit("s"), Gt(0)] = 0.25
    _ramp: Any = field(init=False, repr=False, default=None)

    def __post_init__(self) -> None:
        from rig.mechanisms.cylinder.references import Ramp

        object.__setattr__(self, "_ramp", Ramp(self.travel, self.speeds, self.turn))

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self._ramp.duration)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The constant-speed part of each stroke."""
        return tuple(
            Segment(f"stroke {k} {segment.name}", segment.start, segment.end)
            for k, segment in enumerate(self._ramp.segments, 1)
        )

    def at(self, t: float) -> Any:
        """Return the desired motion at `t`."""
        return self._ramp.at(t)


class Leaning(ScriptedMotion[JointReference], JointDrawing):
    """A motion of a pair as one of the joint's ring: upright and to and fro along one azimuth.

    Parameters
    ----------
    motion : object
        Of a pair, m: what wires are pulled in by where they lie on the ball.
    azimuth : float
        Of the plane that the axis moves in, rad.
    radius : float
        Of the ball, m.
    bases : sequence of tuple of float
        From when on (s) which co-contraction (Pa gauge) instead of the usual one.
    """

    def __init__(
        self, motion: Any, azimuth: float, radius: float, bases: Sequence[tuple[float, float]] = ()
    ) -> None:
        self._motion = motion
        self._bases = tuple(bases)
        self._across = (math.cos(azimuth), math.sin(azimuth))
        self._share = 1.0 / radius
        ScriptedMotion.__init__(self, motion.duration, motion.segments)

    def at(self, t: float) -> Any:
        """Return the desired motion at `t`."""
        along, (x, y) = self._motion.at(t), self._across
        tilt, rate = self._share * along.position, self._share * along.velocity
        rise, square = self._share * along.acceleration, rate * rate
        s, c = math.sin(tilt), math.cos(tilt)
        out, down = rise * c - square * s, -rise * s - square * c
        base = None
        for start, pressure in self._bases:
            base = pressure if t >= start else base
        return JointReference(
            (s * x, s * y, c), (rate * c * x, rate * c * y, -rate * s), (out * x, out * y, down),
            base_pressure=base,
        )  # fmt: skip
