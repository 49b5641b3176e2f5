"""The motion that shows a pair's loop: the ring tilts to and fro through upright and is shaken."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Interval, MinLen, Unit

from controllers.spherical_joint.types import JointReference
from rig.hal.measured_loop import Array
from rig.hal.motion import Segment
from rig.mechanisms.joint.motion import JointDrawing
from rig.mechanisms.pneumatic.shaken_glides import HARMONICS, ShakenGlides

Duration = Annotated[float, Unit("s"), Gt(0)]


@dataclass(frozen=True, slots=True)
class JointProbe(JointDrawing):
    """The axis glides to and fro in a plane at one rate, with a sum of sines on top.

    In the plane of one pair's anchors only that pair moves.

    Parameters
    ----------
    tilt : float
        Of the axis at either end of a glide, rad.
    azimuth : float
        Of the plane, rad from +X to +Y.
    rate : float
        Of the glides, rad/s: well above that from which on the seals slide.
    shake : float
        Greatest rate of the shake, as a share of that of the glide: a ring that turned round on its
        way would stick.
    period : float
        Of the shake, s; each glide is judged over one.
    harmonics : tuple of int
        Which multiples of its frequency it has, the least first.
    settle : float
        Time from the beginning of a glide until it is judged, s; the shake grows in its first half.
    turn : float
        Time in which a glide starts and ends, s.
    repeats : int
        Glides to and fro.
    """

    tilt: Annotated[float, Unit("rad"), Interval(gt=0.0, lt=math.pi / 2)]
    azimuth: Annotated[float, Unit("rad")] = 0.0
    rate: Annotated[float, Unit("rad/s"), Gt(0)] = math.radians(80.0)
    shake: Annotated[float, Interval(gt=0.0, le=0.9)] = 0.25
    period: Duration = 0.5
    harmonics: Annotated[tuple[Annotated[int, Ge(1)], ...], MinLen(3)] = HARMONICS
    settle: Duration = 0.35
    turn: Duration = 0.2
    repeats: Annotated[int, Ge(2)] = 18
    _glides: ShakenGlides = field(init=False, repr=False)

    def __post_init__(self) -> None:
        glides = ShakenGlides(
            self.tilt, self.rate, self.shake, self.period, self.harmonics, self.settle, self.turn,
            self.repeats, "rad",
        )  # fmt: skip
        object.__setattr__(self, "_glides", glides)

    @property
    def frequencies(self) -> Array:
        """Of the shake, Hz."""
        return self._glides.frequencies

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._glides.duration

    @property
    def segments(self) -> tuple[Segment, ...]:
        """One period of the shake in each glide, ``"glide +1"``."""
        return self._glides.segments

    def at(self, t: float) -> JointReference:
        """Return the desired motion at `t`."""
        tilt, rate, rise = self._glides.at(t)
        s, c = math.sin(tilt), math.cos(tilt)
        x, y = math.cos(self.azimuth), math.sin(self.azimuth)
        out, out_rise = c * rate, c * rise - s * rate * rate
        return JointReference(
            (s * x, s * y, c),
            (out * x, out * y, -s * rate),
            (out_rise * x, out_rise * y, -s * rise - c * rate * rate),
        )
