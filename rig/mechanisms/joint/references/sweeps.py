"""Motions of the spherical joint that find out what it can do: where it reaches, what it yields."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Le, MinLen, Unit

from controllers.minimum_jerk import minimum_jerk
from controllers.spherical_joint.poses import Vector, axis_from_tilt
from controllers.spherical_joint.types import JointReference
from rig.hal.motion import Segment
from rig.mechanisms.joint.motion import JointDrawing

Duration = Annotated[float, Unit("s"), Gt(0)]

_ZERO: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class JointSpiral(JointDrawing):
    """The axis winds outwards from upright to a tilt, round after round, and goes home again.

    Tilt and azimuth are the same minimum-jerk function of time, so that the rounds are equally far
    apart and every azimuth is passed once in each of them.

    Parameters
    ----------
    tilt : float
        The greatest tilt of the axis from upright, rad.
    turns : int
        Rounds on the way out.
    duration_out : float
        Time of the way out, s.
    duration_home : float
        Time of the straight way home, s.
    """

    tilt: Annotated[float, Unit("rad"), Interval(gt=0.0, lt=math.pi / 2)]
    turns: Annotated[int, Ge(1)] = 8
    duration_out: Duration = 40.0
    duration_home: Duration = 4.0

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self.duration_out + self.duration_home

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The way out."""
        return (Segment("spiral", 0.0, self.duration_out),)

    def at(self, t: float) -> JointReference:
        """Return the desired motion at `t`."""
        turn = math.tau * self.turns
        if t < self.duration_out:
            tilt, tilt_rate, tilt_rise = minimum_jerk(0.0, self.tilt, self.duration_out, t)
            azimuth, rate, rise = minimum_jerk(0.0, turn, self.duration_out, t)
        else:
            into = t - self.duration_out
            tilt, tilt_rate, tilt_rise = minimum_jerk(self.tilt, 0.0, self.duration_home, into)
            azimuth, rate, rise = turn, 0.0, 0.0
        s, c = math.sin(tilt), math.cos(tilt)
        x, y = math.cos(azimuth), math.sin(azimuth)
        # Outwards, along the circle, and their rates; r and its derivatives are those of sin.
        r1 = c * tilt_rate
        r2 = c * tilt_rise - s * tilt_rate * tilt_rate
        out, across = r2 - s * rate * rate, s * rise + 2.0 * r1 * rate
        return JointReference(
            (s * x, s * y, c),
            (r1 * x - s * rate * y, r1 * y + s * rate * x, -s * tilt_rate),
            (
                out * x - across * y,
                out * y + across * x,
                -s * tilt_rise - c * tilt_rate * tilt_rate,
            ),
        )


@dataclass(frozen=True, slots=True)
class JointStiffness(JointDrawing):
    """The joint is pushed about while its pressures are held, at one mean pressure after another.

    At each one control first brings the pose back and lets it rest. Then the four pressures are
    held and a slow sine of a force is added to the pair (ch1, ch3), too weak to make the joint
    slide: how far it gives is what holds the pose when nobody controls it.

    Parameters
    ----------
    base_pressures : tuple of float
        Mean of the four setpoints, Pa gauge.
    force : float
        Amplitude of the push, N.
    frequency : float
        Of the push, Hz: regulators pass none that is quicker than 10 Hz.
    periods : int
        Of the push; the first one is not judged.
    rest : float
        Time under control before it, s.
    tilt, azimuth : float
        The pose, rad.
    """

    base_pressures: Annotated[tuple[Annotated[float, Unit("Pa"), Gt(0)], ...], MinLen(2)]
    force: Annotated[float, Unit("N"), Gt(0)] = 4.0
    frequency: Annotated[float, Unit("Hz"), Gt(0), Le(10)] = 1.0
    periods: Annotated[int, Ge(2)] = 3
    rest: Duration = 2.0
    tilt: Annotated[float, Unit("rad"), Interval(ge=0.0, lt=math.pi / 2)] = 0.0
    azimuth: Annotated[float, Unit("rad")] = 0.0

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return len(self.base_pressures) * self._each + self.rest

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Each push without its first period, ``"120 kPa"``."""
        return tuple(
            Segment(
                f"{pressure * 1e-3:g} kPa",
                number * self._each + self.rest + 1.0 / self.frequency,
                (number + 1) * self._each,
            )
            for number, pressure in enumerate(self.base_pressures)
        )

    def at(self, t: float) -> JointReference:
        """Return the desired pose at `t`, with mean pressure and push."""
        number = min(int(t // self._each), len(self.base_pressures) - 1)
        into = t - number * self._each - self.rest
        pressure = self.base_pressures[number]
        push = None
        if into < 0.0 and number > 0:
            # From one mean pressure to the next within the first half of the rest.
            before = self.base_pressures[number - 1]
            since = min(into + self.rest, 0.5 * self.rest)
            pressure = minimum_jerk(before, pressure, 0.5 * self.rest, since)[0]
        elif 0.0 <= into < self.periods / self.frequency:
            push = (self.force * math.sin(math.tau * self.frequency * into), 0.0)
        axis = axis_from_tilt(self.tilt, self.azimuth)
        return JointReference(axis, _ZERO, _ZERO, base_pressure=pressure, push=push)

    @property
    def _each(self) -> float:
        """Time at one mean pressure, s."""
        return self.rest + self.periods / self.frequency
