"""Circles of the spherical joint's marker, as its paper draws them, at several speeds and tilts."""

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Interval, MinLen, Unit

from controllers.spherical_joint.great_circle import great_circle
from controllers.spherical_joint.poses import axis_from_tilt
from controllers.spherical_joint.types import JointReference
from rig.hal.motion import Segment
from rig.mechanisms.joint.motion import JointDrawing, Repetition

ConeTilt = Annotated[float, Unit("rad"), Interval(gt=0.0, lt=math.pi / 2)]
Duration = Annotated[float, Unit("s"), Gt(0)]


@dataclass(frozen=True, slots=True)
class CircleTone:
    """One speed of a circle.

    Parameters
    ----------
    frequency : float
        Laps per second, Hz.
    laps : int
        Whole laps at that speed.
    tilt : float, optional
        Half the opening of this circle's cone, rad, if it is another one.
    """

    frequency: Annotated[float, Unit("Hz"), Gt(0)]
    laps: Annotated[int, Ge(1)] = 2
    tilt: ConeTilt | None = None


class _Stage(NamedTuple):
    """One tone on the time axis.

    Parameters
    ----------
    name : str
        Of its segment.
    start, rise : float
        When it begins, and how long it takes to get to its tilt, s.
    before, tilt : float
        Tilt before that and then, rad.
    azimuth : float
        Where the ring points when it begins, rad.
    speed : float
        rad/s.
    steady : float
        Time at that speed, s.
    end : float
        When it ends, s.
    laps : int
        At that speed.
    """

    name: str
    start: float
    rise: float
    before: float
    tilt: float
    azimuth: float
    speed: float
    steady: float
    end: float
    laps: int


@dataclass(frozen=True, slots=True)
class JointCircle(JointDrawing):
    """The axis goes round on a cone, so that the marker draws a horizontal circle.

    It starts towards +X and turns towards +Y.

    Parameters
    ----------
    tilt : float
        Half the cone's opening, rad.
    tones : tuple of CircleTone
        The speeds in their order.
    laps : int, optional
        Laps at every speed, instead of each one's own: a controller that learns needs many.
    ramp : float
        Time in which a speed is reached and left, s.
    rise : float
        Time in which the next tone's tilt is reached, if it is another one, s.

    References
    ----------
    Kobayashi and Saito, "Postural control of the wide angle spherical joint", section 6: theta =
    20 deg cos t, phi = -20 deg sin t, which is a circle but for 0.1 mm in the radius of 18 mm.
    """

    tilt: ConeTilt
    tones: Annotated[tuple[CircleTone, ...], MinLen(1)]
    laps: Annotated[int, Ge(1)] | None = None
    ramp: Duration = 1.0
    rise: Duration = 2.0
    _stages: tuple[_Stage, ...] = field(init=False, repr=False, default=())

    def __post_init__(self) -> None:
        tilts = [self.tilt if tone.tilt is None else tone.tilt for tone in self.tones]
        stages: list[_Stage] = []
        start = azimuth = 0.0
        before = tilts[0]
        for tone, tilt in zip(self.tones, tilts, strict=True):
            name = f"{tone.frequency:g} Hz"
            if len(set(tilts)) > 1:
                name = f"{math.degrees(tilt):g} deg {name}"
            laps = tone.laps if self.laps is None else self.laps
            speed, steady = math.tau * tone.frequency, laps / tone.frequency
            rise = 0.0 if tilt == before else self.rise
            end = start + rise + steady + 2.0 * self.ramp
            stages.append(
                _Stage(name, start, rise, before, tilt, azimuth, speed, steady, end, laps)
            )
            # The whole laps lead back to where they began; the ramps do not.
            azimuth += speed * self.ramp
            start, before = end, tilt
        object.__setattr__(self, "_stages", tuple(stages))

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._stages[-1].end

    @property
    def repetitions(self) -> tuple[Repetition, ...]:
        """The laps at constant speed, one entry per tone."""
        return tuple(
            Repetition(stage.start + stage.rise + self.ramp, stage.steady / stage.laps, stage.laps)
            for stage in self._stages
        )

    @property
    def segments(self) -> tuple[Segment, ...]:
        """One segment per tone, ``"0.2 Hz"``, and with several laps its last, ``"… last lap"``.

        With several tilts, ``"40 deg 0.2 Hz"``.
        """
        segments = []
        for stage, (start, lap, laps) in zip(self._stages, self.repetitions, strict=True):
            end = start + lap * laps
            segments.append(Segment(stage.name, start, end))
            if laps > 1:
                segments.append(Segment(f"{stage.name} last lap", end - lap, end))
        return tuple(segments)

    def at(self, t: float) -> JointReference:
        """Return the desired motion at `t`."""
        stage = self._stages[-1]
        for stage in self._stages:
            if t < stage.end:
                break
        into = t - stage.start
        if into < stage.rise:
            start = axis_from_tilt(stage.before, stage.azimuth)
            end = axis_from_tilt(stage.tilt, stage.azimuth)
            return great_circle(start, end, stage.rise, into)
        turned, rate, rise = _ramped(stage.speed, stage.steady, self.ramp, into - stage.rise)
        azimuth = stage.azimuth + turned
        s, c = math.sin(stage.tilt), math.cos(stage.tilt)
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
