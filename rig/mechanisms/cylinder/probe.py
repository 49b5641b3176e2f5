"""The motion that shows a loop: a pair glides to and fro and is shaken on its way."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Interval, MinLen, Unit

from controllers.cylinder.types import PairReference
from rig.hal.measured_loop import Array
from rig.hal.motion import Segment
from rig.mechanisms.cylinder.references import Duration, PairMotion
from rig.mechanisms.pneumatic.shaken_glides import HARMONICS, ShakenGlides


@dataclass(frozen=True, slots=True)
class Probe(PairMotion):
    """Glides to and fro at one speed, with a sum of sines on top.

    Parameters
    ----------
    travel : float
        Half the stroke of a glide, m.
    speed : float
        Of the glides, m/s: well above that from which on the seals slide.
    shake : float
        Greatest speed of the shake, as a share of that of the glide: a pair that turned round on
        its way would stick.
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

    travel: Annotated[float, Unit("m"), Gt(0)]
    speed: Annotated[float, Unit("m/s"), Gt(0)] = 30e-3
    shake: Annotated[float, Interval(gt=0.0, le=0.9)] = 0.25
    period: Duration = 0.5
    harmonics: Annotated[tuple[Annotated[int, Ge(1)], ...], MinLen(3)] = HARMONICS
    settle: Duration = 0.35
    turn: Duration = 0.2
    repeats: Annotated[int, Ge(2)] = 18
    _glides: ShakenGlides = field(init=False, repr=False)

    def __post_init__(self) -> None:
        glides = ShakenGlides(
            self.travel, self.speed, self.shake, self.period, self.harmonics, self.settle,
            self.turn, self.repeats, "m",
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

    def at(self, t: float) -> PairReference:
        """Return the desired motion at `t`."""
        return PairReference(*self._glides.at(t))
