"""PID on the pair's position: the reference that the other controllers are measured against."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Unit

from controllers.cylinder.differential import DifferentialRange
from controllers.cylinder.law import Integral, Output, PairLaw
from controllers.cylinder.types import PairModel


@dataclass(frozen=True, slots=True)
class PidSettings:
    """Gains from position to differential pressure; tuned for standard seals at 1 kHz.

    Parameters
    ----------
    proportional : float
        Pa/m.
    integral : float
        Pa/(m s).
    derivative : float
        Pa s/m.
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


class Pid(PairLaw[PidSettings]):
    """PID with a filtered derivative and clamped anti-windup.

    References
    ----------
    K. J. Åström, T. Hägglund, "Advanced PID control", ISA, 2006, chapters 3 (filtered derivative,
    bumpless transfer, conditional integration).
    """

    Settings = PidSettings

    def __init__(self, settings: PidSettings, model: PairModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._range = DifferentialRange(model, settings.pressure_floor)
        self._integral = Integral()
        self._integral_step = settings.integral * period
        self._per_period = 1.0 / period
        self._share = 1.0 - math.exp(-period / settings.derivative_time)
        self._position = 0.0
        self._velocity = 0.0

    def _begin(self, position: float, difference: float) -> None:
        self._integral.reset(self._range.clip(difference))
        self._position = position
        self._velocity = 0.0

    def _step(
        self,
        measured: float,
        difference: float,
        wanted: float,
        wanted_velocity: float,
        wanted_acceleration: float,
        load: float,
    ) -> Output:
        settings, integral = self.settings, self._integral
        slope = (measured - self._position) * self._per_period
        self._position = measured
        self._velocity += self._share * (slope - self._velocity)
        error = wanted - measured
        feedforward = self._per_area * load
        wish = integral.wish(
            settings.proportional * error
            + settings.derivative * (wanted_velocity - self._velocity)
            + feedforward
        )
        applied = self._range.clip(wish)
        integral.grow(self._integral_step, error, wish - applied)
        return (
            *self._range.share(applied),
            self._velocity,
            -self._area * integral.value,
            self._area * (wish - feedforward),
        )
