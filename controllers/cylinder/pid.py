"""PID on the pair's position: the reference that the other controllers are measured against."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Unit

from controllers.base import Tunable
from controllers.compiled import inlined
from controllers.cylinder.differential import DifferentialRange
from controllers.cylinder.law import Integral, Output
from controllers.cylinder.numeric_law import NumericPairLaw, PairNumbers
from controllers.cylinder.types import PairModel

_clip = inlined(DifferentialRange.clip)
_share = inlined(DifferentialRange.share)
_wish = inlined(Integral.wish)
_grow = inlined(Integral.grow)


@dataclass(frozen=True, slots=True)
class PidSettings:
    """Gains from position to differential pressure; tuned for standard seals at 1 kHz.

    Parameters
    ----------
    proportional : float
        Differential pressure for each metre of error, Pa/m.
    integral : float
        The same for what the error adds up to, Pa/(m s).
    derivative : float
        The same for how fast the error changes, Pa s/m.
    derivative_time : float
        Time constant of the filter of the derivative, s.
    pressure_floor : float
        No setpoint goes below, Pa gauge, so that no wire goes slack.
    """

    proportional: Annotated[float, Unit("Pa/m"), Ge(0)] = 2.0e8
    integral: Annotated[float, Unit("Pa/(m s)"), Ge(0)] = 1.0e9
    derivative: Annotated[float, Unit("Pa s/m"), Ge(0)] = 1.0e7
    derivative_time: Annotated[float, Unit("s"), Gt(0)] = 5e-4
    pressure_floor: Annotated[float, Unit("Pa"), Ge(0)] = 20e3


class PidLaw(PairNumbers):
    """The numbers of a `Pid`, and its step of one period.

    Parameters
    ----------
    settings : PidSettings
        Gains.
    model : PairModel
        Pressures and area.
    period : float
        The loop's period, s.
    """

    def __init__(self, settings: PidSettings, model: PairModel, period: float) -> None:
        self._area = model.area
        self._per_area = 1.0 / model.area
        self._proportional = settings.proportional
        self._derivative = settings.derivative
        self._integral_step = settings.integral * period
        self._per_period = 1.0 / period
        self._share = 1.0 - math.exp(-period / settings.derivative_time)
        self._range = DifferentialRange(model, settings.pressure_floor)
        self._integral = Integral()
        self._position = 0.0
        self._velocity = 0.0

    def reset(self, position: float, difference: float) -> None:
        """Start bumplessly; see `PairNumbers.reset`."""
        self._integral.reset(self._range.clip(difference))
        self._position = position
        self._velocity = 0.0

    def step(
        self,
        measured: float,
        difference: float,
        wanted: float,
        wanted_velocity: float,
        wanted_acceleration: float,
        load: float,
    ) -> Output:
        """Advance by one period; see `PairNumbers.step`."""
        integral = self._integral
        slope = (measured - self._position) * self._per_period
        self._position = measured
        self._velocity += self._share * (slope - self._velocity)
        error = wanted - measured
        feedforward = self._per_area * load
        wish = _wish(
            integral,
            self._proportional * error
            + self._derivative * (wanted_velocity - self._velocity)
            + feedforward,
        )
        applied = _clip(self._range, wish)
        _grow(integral, self._integral_step, error, wish - applied)
        first, second = _share(self._range, applied)
        return (
            first,
            second,
            self._velocity,
            -self._area * integral.value,
            self._area * (wish - feedforward),
        )


inlined(PidLaw.step)


class Pid(NumericPairLaw[PidSettings]):
    """PID with a filtered derivative and clamped anti-windup.

    References
    ----------
    K. J. Åström, T. Hägglund, "Advanced PID control", ISA, 2006, chapters 3 (filtered derivative,
    bumpless transfer, conditional integration).
    """

    Settings = PidSettings
    Numbers = PidLaw
    tunables = (
        Tunable("proportional", 1e5, 5e8),
        Tunable("integral", 1e5, 5e9),
        Tunable("derivative", 1e3, 5e7),
        Tunable("derivative_time", 1e-4, 2e-2),
    )
    online = (
        Tunable("proportional", 1e5, 5e8),
        Tunable("integral", 0.0, 5e9),
        Tunable("derivative", 0.0, 5e7),
    )
