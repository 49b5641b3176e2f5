"""Motions of the ring along one line on the ball, upright and to and fro."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Gt, MinLen, Unit

from controllers.cylinder.types import PairReference
from controllers.spherical_joint.types import JointReference
from rig.hal.motion import Motion, Segment
from rig.mechanisms.cylinder.references import PairMotion, Ramp
from rig.mechanisms.joint.motion import JointDrawing


@dataclass(frozen=True, slots=True)
class Strokes(PairMotion):
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
    _ramp: Ramp = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_ramp", Ramp(self.travel, self.speeds, self.turn))

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._ramp.duration

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The constant-speed part of each stroke."""
        return tuple(
            Segment(f"stroke {k} {segment.name}", segment.start, segment.end)
            for k, segment in enumerate(self._ramp.segments, 1)
        )

    def at(self, t: float) -> PairReference:
        """Return the desired motion at `t`."""
        return self._ramp.at(t)


class Leaning(JointDrawing):
    """A motion of a pair as one of the joint's ring: upright and to and fro along one azimuth.

    Parameters
    ----------
    motion : Motion of PairReference
        What wires are pulled in by where they lie on the ball, m.
    azimuth : float
        Of the plane that the axis moves in, rad.
    radius : float
        Of the ball, m.
    bases : sequence of tuple of float
        From when on (s) which co-contraction (Pa gauge) instead of the usual one.
    """

    def __init__(
        self,
        motion: Motion[PairReference],
        azimuth: float,
        radius: float,
        bases: Sequence[tuple[float, float]] = (),
    ) -> None:
        self._motion = motion
        self._bases = tuple(bases)
        self._across = (math.cos(azimuth), math.sin(azimuth))
        self._share = 1.0 / radius

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._motion.duration

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Those of the pair's motion."""
        return self._motion.segments

    def at(self, t: float) -> JointReference:
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
