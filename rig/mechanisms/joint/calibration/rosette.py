"""The motion that tells camera and geometry apart: a rosette, there and back the same way.

The ring swings through upright while the plane of the swing turns, so that poses of every tilt in
every direction are passed. Then it goes the same way back: each pose is passed in both senses,
and what friction adds to the wires' stretch in one of them it takes off in the other.
"""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Unit

from controllers.spherical_joint.types import JointReference
from rig.hal.motion import Segment
from rig.mechanisms.joint.motion import JointDrawing

UPRIGHT = "upright"
"""Name of the stretch in which the ring stands upright."""


@dataclass(frozen=True, slots=True)
class Rosette(JointDrawing):
    """Swings through upright in a plane that turns, first on and then back.

    Parameters
    ----------
    tilt : float
        Greatest, rad.
    petals : int
        Half swings on the way on; as many on the way back.
    period : float
        Time of a half swing, s.
    rest : float
        Time upright at the beginning, s.
    ramp : float
        Time in which the swing's speed is reached and left, s.
    """

    tilt: Annotated[float, Unit("rad"), Interval(gt=0.0, lt=math.pi / 2)]
    petals: Annotated[int, Ge(2)] = 12
    period: Annotated[float, Unit("s"), Gt(0)] = 2.0
    rest: Annotated[float, Unit("s"), Gt(0)] = 1.0
    ramp: Annotated[float, Unit("s"), Gt(0)] = 0.5

    @property
    def one_way(self) -> float:
        """Time of either way, s: the ramps reach half a speed in the mean."""
        return self.petals * self.period + self.ramp

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self.rest + 2.0 * self.one_way

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The rest upright, and each petal on its way on and back."""
        stretches = [Segment(UPRIGHT, 0.5 * self.rest, self.rest)]
        for name, start in (("on", self.rest), ("back", self.rest + self.one_way)):
            each = self.one_way / self.petals
            stretches += [
                Segment(f"petal {name} {k + 1}", start + k * each, start + (k + 1) * each)
                for k in range(self.petals)
            ]
        return tuple(stretches)

    def at(self, t: float) -> JointReference:
        """Return the desired motion at `t`."""
        on = t - self.rest
        back = on - self.one_way
        full = math.pi * self.petals
        if on <= 0.0:
            phase, rate, rise = 0.0, 0.0, 0.0
        elif back <= 0.0:
            phase, rate, rise = self._swing(on)
        else:
            phase, rate, rise = self._swing(back)
            phase, rate, rise = full - phase, -rate, -rise
        return self._axis(phase, rate, rise)

    def _swing(self, t: float) -> tuple[float, float, float]:
        """Return phase, rate and its derivative on one way, from rest to rest."""
        rate, ramp, end = math.pi / self.period, self.ramp, self.one_way
        if t < ramp:
            x = t / ramp
            return (
                rate * ramp * x**3 * (1.0 - 0.5 * x),
                rate * x * x * (3.0 - 2.0 * x),
                rate / ramp * 6.0 * x * (1.0 - x),
            )
        if t <= end - ramp:
            return rate * (t - 0.5 * ramp), rate, 0.0
        phase, speed, rise = self._swing(max(end - t, 0.0))
        return math.pi * self.petals - phase, speed, -rise

    def _axis(self, phase: float, rate: float, rise: float) -> JointReference:
        # The swing sin(phase) leans towards an azimuth that makes half a turn over all petals.
        turning = 1.0 / self.petals
        azimuth = turning * phase
        tilt, slope = self.tilt * math.sin(phase), self.tilt * math.cos(phase)
        s, c, x, y = math.sin(tilt), math.cos(tilt), math.cos(azimuth), math.sin(azimuth)
        # Along the lean and across it, derivatives by the phase.
        out, across = c * slope, s * turning
        out2 = -s * slope * slope - c * tilt - s * turning * turning
        across2 = 2.0 * c * slope * turning
        fall, fall2 = -s * slope, -c * slope * slope + s * tilt
        first = (out * x - across * y, out * y + across * x, fall)
        second = (out2 * x - across2 * y, out2 * y + across2 * x, fall2)
        square = rate * rate
        return JointReference(
            (s * x, s * y, c),
            (rate * first[0], rate * first[1], rate * first[2]),
            (
                square * second[0] + rise * first[0],
                square * second[1] + rise * first[1],
                square * second[2] + rise * first[2],
            ),
        )
