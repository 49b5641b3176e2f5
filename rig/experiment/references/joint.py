"""References for the spherical joint, as an experiment names them.

They say where the ring's axis points, whatever wires and conventions a controller uses. Every
reference starts and ends at rest.
"""

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Interval, MinLen, Unit

from controllers.spherical_joint.great_circle import great_circle
from controllers.spherical_joint.poses import Vector, axis_from_tilt
from controllers.spherical_joint.types import JointReference
from rig.runtime.motion import Segment

Tilt = Annotated[float, Unit("rad"), Interval(ge=0.0, lt=math.pi / 2)]
Angle = Annotated[float, Unit("rad")]
Duration = Annotated[float, Unit("s"), Gt(0)]

_ZERO: Vector = (0.0, 0.0, 0.0)


class Repetition(NamedTuple):
    """A stretch that a motion repeats.

    Parameters
    ----------
    start : float
        When its first lap begins, s.
    lap : float
        How long a lap takes, s.
    laps : int
        How many there are.
    """

    start: float
    lap: float
    laps: int


@dataclass(frozen=True, slots=True)
class CircleTone:
    """One speed of a circle.

    Parameters
    ----------
    frequency : float
        Laps per second, Hz.
    laps : int
        Whole laps at that speed.
    """

    frequency: Annotated[float, Unit("Hz"), Gt(0)]
    laps: Annotated[int, Ge(1)] = 2


@dataclass(frozen=True, slots=True)
class JointCircle:
    """The axis goes round on a cone, so that the marker draws a horizontal circle.

    It starts towards +X and turns towards +Y.

    Parameters
    ----------
    tilt : float
        Half the cone's opening, rad.
    tones : tuple of CircleTone
        The speeds in their order.
    ramp : float
        Time in which a speed is reached and left, s.

    References
    ----------
    Kobayashi and Saito, "Postural control of the wide angle spherical joint", section 6: theta =
    20 deg cos t, phi = -20 deg sin t, which is a circle but for 0.1 mm in the radius of 18 mm.
    """

    tilt: Annotated[float, Unit("rad"), Interval(gt=0.0, lt=math.pi / 2)]
    tones: Annotated[tuple[CircleTone, ...], MinLen(1)]
    ramp: Duration = 1.0

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return sum(tone.laps / tone.frequency + 2.0 * self.ramp for tone in self.tones)

    @property
    def repetitions(self) -> tuple[Repetition, ...]:
        """The laps at constant speed, one entry per tone."""
        found = []
        start = 0.0
        for tone in self.tones:
            found.append(Repetition(start + self.ramp, 1.0 / tone.frequency, tone.laps))
            start += tone.laps / tone.frequency + 2.0 * self.ramp
        return tuple(found)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """One segment per tone, ``"0.2 Hz"``, and with several laps its last, ``"… last lap"``."""
        segments = []
        for tone, (start, lap, laps) in zip(self.tones, self.repetitions, strict=True):
            name, end = f"{tone.frequency:g} Hz", start + lap * laps
            segments.append(Segment(name, start, end))
            if laps > 1:
                segments.append(Segment(f"{name} last lap", end - lap, end))
        return tuple(segments)

    def at(self, t: float) -> JointReference:
        """Return the desired motion at `t`."""
        azimuth = rate = rise = start = before = 0.0
        for tone in self.tones:
            speed, steady = math.tau * tone.frequency, tone.laps / tone.frequency
            azimuth, rate, rise = _ramped(speed, steady, self.ramp, t - start)
            azimuth += before
            start += steady + 2.0 * self.ramp
            if t < start:
                break
            before += speed * self.ramp  # the whole laps lead back to where they began
        s, c = math.sin(self.tilt), math.cos(self.tilt)
        x, y = math.cos(azimuth), math.sin(azimuth)
        return JointReference(
            (s * x, s * y, c),
            (-s * rate * y, s * rate * x, 0.0),
            (-s * (rise * y + rate * rate * x), s * (rise * x - rate * rate * y), 0.0),
        )


def _ramped(rate: float, steady: float, ramp: float, t: float) -> tuple[float, float, float]:
    """Return angle, rate and its derivative of a turn that is reached and left smoothly."""
    if t < ramp:
        x = t / ramp
        return (
            rate * ramp * x**3 * (1.0 - 0.5 * x),
            rate * x * x * (3.0 - 2.0 * x),
            rate / ramp * 6.0 * x * (1.0 - x),
        )
    if t < ramp + steady:
        return 0.5 * rate * ramp + rate * (t - ramp), rate, 0.0
    total = rate * (steady + ramp)
    angle, speed, rise = _ramped(rate, steady, ramp, max(steady + 2.0 * ramp - t, 0.0))
    return total - angle, speed, -rise


@dataclass(frozen=True, slots=True)
class JointPose:
    """Where the axis points.

    Parameters
    ----------
    tilt : float
        From upright, rad.
    azimuth : float
        Towards which side, from +X towards +Y, rad.
    """

    tilt: Tilt
    azimuth: Angle = 0.0

    @property
    def axis(self) -> Vector:
        """The ring's axis, a unit vector."""
        return axis_from_tilt(self.tilt, self.azimuth)


@dataclass(frozen=True, slots=True)
class JointPoses:
    """Minimum-jerk moves from pose to pose, with a dwell in each.

    Parameters
    ----------
    poses : tuple of JointPose
        In their order.
    rise : float
        Time of each move, s.
    dwell : float
        Time in each pose, s; its second half is judged.
    """

    poses: Annotated[tuple[JointPose, ...], MinLen(2)]
    rise: Duration = 1.0
    dwell: Duration = 2.0
    _axes: tuple[Vector, ...] = field(init=False, repr=False, default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "_axes", tuple(pose.axis for pose in self.poses))

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self.dwell + (len(self.poses) - 1) * (self.rise + self.dwell)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The second half of each dwell but the first, ``"hold 20 deg at 90 deg #1"``."""
        each = self.rise + self.dwell
        return tuple(
            Segment(
                f"hold {math.degrees(pose.tilt):g} deg at {math.degrees(pose.azimuth):g} deg "
                f"#{number}",
                number * each + 0.5 * self.dwell,
                number * each + self.dwell,
            )
            for number, pose in enumerate(self.poses)
            if number > 0
        )

    def at(self, t: float) -> JointReference:
        """Return the desired motion at `t`."""
        each = self.rise + self.dwell
        number = min(int(t // each), len(self._axes) - 1)
        if number == len(self._axes) - 1:
            return JointReference(self._axes[-1], _ZERO, _ZERO)
        into = t - number * each - self.dwell
        return great_circle(self._axes[number], self._axes[number + 1], self.rise, into)
