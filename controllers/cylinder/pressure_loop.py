"""The inner loop of a chamber on a proportional valve: from a wanted pressure to an opening.

The wanted pressure passes a reference model of second order, which is the response that the laws of
a pair are told of, as they are of a regulator's. The flow that this pressure and its rate take,

    m = (V p' / n + p V') / (R T),

is worked out with the volume that the rod's encoder tells, and turned into an opening by the
inverse of the valve's flow map. What is measured corrects it, compared with the pressure that the
model had as long ago as valve and sensor take.

What stays off while a port passes air is learnt as the opening at which that port begins. One that
is told wrong by 1 % makes 20 kPa in a chamber that is nearly shut: the flow that makes up for an
error is in proportion to the volume.

References
----------
E. Richer, Y. Hurmuzlu, "A high performance pneumatic force actuator system: part II", J. Dyn. Syst.
Meas. Control 122(3), 2000: an inner loop of the flow, inverted from pressures and opening.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Final

from annotated_types import Ge, Gt, Le, Unit

from controllers.compiled import PlainNumbers, inlined
from controllers.cylinder.valve_flow import (
    AIR,
    ATMOSPHERE,
    POLYTROPIC,
    SupplyModel,
    ValveFlow,
    ValveModel,
)

_EXHAUST: Final = -1.0
_LEAST_VOLUME: Final = 1e-7
"""m³: a rod that reads beyond its stroke leaves so much."""

_LEARNT: Final = 0.02
"""A port begins by no more than this off the opening that is told."""
_HEEDED: Final = 20e3
"""More than this of an error teaches nothing, Pa: a port that is fully open cannot do better."""

_flow_to_opening = inlined(ValveFlow.opening)


@dataclass(frozen=True, slots=True)
class PressureLoopSettings:
    """Gains of the inner loop.

    Parameters
    ----------
    gain : float
        Rate of the pressure asked for over its error, rad/s.
    lag : float
        From an opening until the pressure shows it, s: valve, sensor and cycle.
    preview : float
        So much earlier the flow is asked for, s: what valve and cycle take of it.
    speed_bandwidth : float
        Of the low-pass of the rod's speed, rad/s.
    learning : float
        How fast the openings at which the ports begin are learnt, 1/(Pa s); 0: they are as told.
    """

    gain: Annotated[float, Unit("rad/s"), Gt(0), Le(2000)] = 80.0
    lag: Annotated[float, Unit("s"), Ge(0), Le(0.05)] = 5e-3
    preview: Annotated[float, Unit("s"), Ge(0), Le(0.05)] = 3e-3
    speed_bandwidth: Annotated[float, Unit("rad/s"), Gt(0)] = 300.0
    learning: Annotated[float, Unit("1/(Pa s)"), Ge(0), Le(1e-3)] = 1.4e-5


@dataclass(frozen=True, slots=True)
class ChamberModel:
    """A chamber as the inner loop believes it.

    Parameters
    ----------
    area : float
        Of the piston, m².
    volume : float
        Where the rod's extension is 0, m³: all of the stroke and what is dead.
    bandwidth, damping : float
        Of the response that the laws are told of, rad/s and 1.
    """

    area: float
    volume: float
    bandwidth: float
    damping: float


class PressureLoop(PlainNumbers):
    """The numbers of one chamber's inner loop, and its step of one period.

    Parameters
    ----------
    settings : PressureLoopSettings
        Gains.
    chamber : ChamberModel
        The chamber.
    valve, supply : ValveModel, SupplyModel
        What feeds it.
    period : float
        The loop's period, s.
    """

    def __init__(
        self,
        settings: PressureLoopSettings,
        chamber: ChamberModel,
        valve: ValveModel,
        supply: SupplyModel,
        period: float,
    ) -> None:
        self._flow = ValveFlow(valve, supply)
        middle = 0.5 * (valve.feeds_from + valve.exhausts_from)
        self._earliest, self._latest = valve.exhausts_from - _LEARNT, valve.feeds_from + _LEARNT
        self._middle = middle
        self._learning = settings.learning * period
        self._area, self._volume = chamber.area, chamber.volume
        self._stiffness = chamber.bandwidth**2
        self._drag = 2.0 * chamber.damping * chamber.bandwidth
        self._pp, self._pr, self._rp, self._rr = _response(
            chamber.bandwidth, chamber.damping, period
        )
        self._gain = settings.gain
        self._preview = settings.preview
        seen = max(settings.lag - settings.preview, 0.0)
        self._seen_share = period / (seen + period)
        self._per_period = 1.0 / period
        self._speed_share = 1.0 - math.exp(-settings.speed_bandwidth * period)
        self._period = period
        self.pressure = 0.0
        """That the model has now, Pa gauge."""
        self.rate = 0.0
        """Its rate, Pa/s."""
        self.seen = 0.0
        """That the sensor should show now, Pa gauge."""
        self._extension = self._speed = 0.0

    def reset(self, pressure: float, extension: float) -> None:
        """Start at rest at a measured pressure (Pa gauge) and extension (m)."""
        self.pressure = self.seen = pressure
        self.rate = self._speed = 0.0
        self._extension = extension

    def step(self, wanted: float, measured: float, extension: float) -> float:
        """Advance by one period and return the opening, -1 … 1.

        Parameters
        ----------
        wanted, measured : float
            Pressures, Pa gauge; 0 and less are wanted where the chamber is to be vented.
        extension : float
            Of the rod, m.
        """
        moved = (extension - self._extension) * self._per_period
        self._extension = extension
        self._speed += self._speed_share * (moved - self._speed)
        gap, rate = self.pressure - wanted, self.rate
        self.pressure = wanted + self._pp * gap + self._pr * rate
        self.rate = self._rp * gap + self._rr * rate
        self.seen += self._seen_share * (self.pressure - self.seen)
        if wanted <= 0.0:
            return _EXHAUST
        asked = self.rate - self._preview * (
            self._stiffness * (self.pressure - wanted) + self._drag * self.rate
        )
        asked += self._gain * (self.seen - measured)
        volume = self._volume - self._area * extension
        volume = max(volume, _LEAST_VOLUME)
        absolute = max(measured, -0.5 * ATMOSPHERE) + ATMOSPHERE
        flow = (volume * asked / POLYTROPIC - absolute * self._area * self._speed) / AIR
        opening = _flow_to_opening(self._flow, flow, absolute)
        _learn(self, opening, self.seen - measured)
        return opening


@inlined
def _learn(loop: PressureLoop, opening: float, short: float) -> None:
    """Move the opening at which the port begins that passes air, by a pressure's error, Pa."""
    valve = loop._flow
    change = loop._learning * min(max(short, -_HEEDED), _HEEDED)
    if opening > valve.feeds:
        valve.feeds = min(max(valve.feeds + change, loop._middle), loop._latest)
    elif opening < valve.exhausts:
        valve.exhausts = min(max(valve.exhausts + change, loop._earliest), loop._middle)


inlined(PressureLoop.step)


def _response(bandwidth: float, damping: float, time: float) -> tuple[float, float, float, float]:
    """Return what gap and rate of a second order come to in a time, by gap and rate before."""
    w, z = bandwidth, damping
    square = w * w * (z * z - 1.0)
    if abs(square) < 1e-8 * w * w:
        even, odd = 1.0, time
    elif square < 0.0:
        turn = math.sqrt(-square)
        even, odd = math.cos(turn * time), math.sin(turn * time) / turn
    else:
        turn = math.sqrt(square)
        even, odd = math.cosh(turn * time), math.sinh(turn * time) / turn
    fade = math.exp(-z * w * time)
    return (
        fade * (even + z * w * odd),
        fade * odd,
        -fade * w * w * odd,
        fade * (even - z * w * odd),
    )
