"""PID on the pair's position: the reference that the other controllers are measured against."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Unit

from controllers.cylinder.differential import DifferentialRange
from controllers.cylinder.types import (
    PairCommand,
    PairEstimate,
    PairModel,
    PairReference,
    PairState,
)


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


class Pid:
    """PID with a filtered derivative and clamped anti-windup.

    Parameters
    ----------
    settings : PidSettings
        Gains.
    model : PairModel
        Pressures and area.
    period : float
        The loop's period, s.

    References
    ----------
    K. J. Åström, T. Hägglund, "Advanced PID control", ISA, 2006, chapters 3 (filtered derivative,
    bumpless transfer, conditional integration).
    """

    Settings = PidSettings

    def __init__(self, settings: PidSettings, model: PairModel, period: float) -> None:
        self._settings = settings
        self._area = model.area
        self._per_area = 1.0 / model.area
        self._range = DifferentialRange(model, settings.pressure_floor)
        self._integral_step = settings.integral * period
        self._per_period = 1.0 / period
        self._share = 1.0 - math.exp(-period / settings.derivative_time)
        self._integral = 0.0
        self._position = 0.0
        self._velocity = 0.0
        self._started = False
        self.estimate = PairEstimate(0.0, 0.0)
        """Filtered velocity, and the force that the integral holds against."""
        self.correction = 0.0
        """Force of the last update that came from errors and not from the reference, N."""

    def compile(self) -> None:
        """Do nothing: there is nothing to compile."""

    def reset(self, state: PairState) -> None:
        """Start bumplessly: the first command is the measured differential."""
        self._integral = state.agonist - state.antagonist
        self._position = state.position
        self._velocity = 0.0
        self._started = False
        self.estimate = PairEstimate(0.0, -self._area * self._integral)

    def update(self, state: PairState, reference: PairReference, load: float = 0.0) -> PairCommand:
        """Return the setpoints for this period.

        Parameters
        ----------
        state, reference : PairState, PairReference
            What is, and what should be.
        load : float
            Force that the motion is known to take beyond the pair's own, N: what hangs on it.
        """
        settings = self._settings
        slope = (state.position - self._position) * self._per_period
        self._position = state.position
        self._velocity += self._share * (slope - self._velocity)
        error = reference.position - state.position
        feedforward = self._per_area * load
        direct = (
            settings.proportional * error
            + settings.derivative * (reference.velocity - self._velocity)
            + feedforward
        )
        if not self._started:
            self._started = True
            self._integral = self._range.clip(self._integral) - direct
        differential = direct + self._integral
        self.correction = self._area * (differential - feedforward)
        applied = self._range.clip(differential)
        if (differential - applied) * error <= 0.0:
            self._integral += self._integral_step * error
        self.estimate = PairEstimate(self._velocity, -self._area * self._integral)
        return self._range.split(applied)
