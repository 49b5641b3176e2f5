"""A plain PI law for an antagonistic pair, beside those that it comes with."""

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


@dataclass(frozen=True, slots=True)
class PiSettings:
    """Gains from position to differential pressure.

    Parameters
    ----------
    proportional : float
        Pa/m.
    integral : float
        Pa/(m s).
    """

    proportional: Annotated[float, Unit("Pa/m"), Ge(0)] = 3e7
    integral: Annotated[float, Unit("Pa/(m s)"), Ge(0)] = 2e8


class Pi(Law[PiSettings, PairModel, PairReference, PairState, PairCommand]):
    """PI on the pair's position, around the base pressure."""

    Settings = PiSettings

    def __init__(self, settings: PiSettings, model: PairModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._proportional = settings.proportional
        self._integral_step = settings.integral * period
        self._base = model.base_pressure
        self._most = 2.0 * min(model.base_pressure, model.pressure_max - model.base_pressure)
        self._integral = 0.0
        self._measured: float | None = None
        self.estimate = PairEstimate(0.0, 0.0)
        """Nothing: the law estimates neither velocity nor disturbance."""

    def reset(self, state: PairState) -> None:
        """Start bumplessly: the first command is the measured differential."""
        self._measured = state.agonist - state.antagonist

    def update(self, state: PairState, reference: PairReference) -> PairCommand:
        """Return the setpoints for this period."""
        error = reference.position - state.position
        direct = self._proportional * error
        if self._measured is not None:
            self._integral, self._measured = self._measured - direct, None
        wanted = direct + self._integral
        differential = min(max(wanted, -self._most), self._most)
        if differential == wanted:  # at its end the integral stands still
            self._integral += self._integral_step * error
        return PairCommand(self._base + 0.5 * differential, self._base - 0.5 * differential)
