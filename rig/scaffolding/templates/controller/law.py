"""A law to begin with: proportional, integral and derivative on the pair's position.

A law sees nothing but what it is given: no clock, no files, no randomness. The same inputs give the
same commands, so that a run can be replayed.
"""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Unit

from controllers.base import Law
from controllers.cylinder.types import (
    PairCommand,
    PairEstimate,
    PairModel,
    PairReference,
    PairState,
)

_SMOOTH = 0.3
"""Share of a new slope that the velocity takes: an encoder's steps are not a motion."""


@dataclass(frozen=True, slots=True)
class MyLawSettings:
    """Gains from position to differential pressure; a profile may give others.

    These hold on the cylinder that ships, twice as much swings: a slower regulator bears less.

    Parameters
    ----------
    proportional : float
        Differential pressure for each metre of error, Pa/m.
    integral : float
        The same for what the error adds up to, Pa/(m s).
    derivative : float
        The same for how fast the error changes, Pa s/m.
    """

    proportional: Annotated[float, Unit("Pa/m"), Ge(0)] = 5e7
    integral: Annotated[float, Unit("Pa/(m s)"), Ge(0)] = 2e8
    derivative: Annotated[float, Unit("Pa s/m"), Ge(0)] = 2.5e6


class MyLaw(Law[MyLawSettings, PairModel, PairReference, PairState, PairCommand]):
    """Proportional, integral and derivative, around the base pressure."""

    Settings = MyLawSettings

    def __init__(self, settings: MyLawSettings, model: PairModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._proportional = settings.proportional
        self._integral_step = settings.integral * period
        self._derivative = settings.derivative
        self._per_period = 1.0 / period
        self._base = model.base_pressure
        # As much as both chambers can do around their mean, Pa.
        self._most = 2.0 * min(model.base_pressure, model.pressure_max - model.base_pressure)
        self._integral = self._position = self._velocity = 0.0
        self._measured: float | None = None
        self.estimate = PairEstimate(0.0, 0.0)
        """Velocity (m/s) and disturbance (N) for the log, if your law estimates them."""

    def reset(self, state: PairState) -> None:
        """Start without a bump: the first command is what is measured now."""
        self._measured = state.agonist - state.antagonist
        self._position, self._velocity = state.position, 0.0

    def update(self, state: PairState, reference: PairReference) -> PairCommand:
        """Return the setpoints of both chambers for this period, Pa gauge."""
        slope = (state.position - self._position) * self._per_period
        self._position = state.position
        self._velocity += _SMOOTH * (slope - self._velocity)
        error = reference.position - state.position
        direct = self._proportional * error
        direct += self._derivative * (reference.velocity - self._velocity)
        if self._measured is not None:
            self._integral, self._measured = self._measured - direct, None
        wanted = direct + self._integral
        applied = min(max(wanted, -self._most), self._most)
        if applied == wanted:  # else the integral would wind up
            self._integral += self._integral_step * error
        return PairCommand(self._base + 0.5 * applied, self._base - 0.5 * applied)
