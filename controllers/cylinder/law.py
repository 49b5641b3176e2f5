"""The frame of the laws of a pair: from measured pressures to setpoints, and the integral."""

from abc import abstractmethod
from collections.abc import Callable
from typing import Any

from controllers.base import Chosen, Law
from controllers.compiled import PlainNumbers
from controllers.cylinder.types import (
    PairCommand,
    PairEstimate,
    PairModel,
    PairReference,
    PairState,
)
from controllers.named_tuples import new_tuple

Output = tuple[float, float, float, float, float]
"""Setpoints (Pa), velocity (m/s), disturbance (N), force because of errors (N)."""


class PairLaw(Law[Chosen, PairModel, PairReference, PairState, PairCommand]):
    """A position controller of one antagonistic pair."""

    _step: Callable[[float, float, float, float, float, float], Output]
    """Takes the measured position (m), the agonist's over the antagonist's pressure (Pa), position,
    velocity and acceleration of the reference (m, m/s, m/s²), and the load (N)."""

    def __init__(self, settings: Chosen, model: PairModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._area = model.area
        self._per_area = 1.0 / model.area
        self.estimate = PairEstimate(0.0, 0.0)
        """Velocity at the time of use, and force that the pressures do not explain."""
        self.correction = 0.0
        """Force of the last update that came from errors and not from the reference, N."""

    def reset(self, state: PairState) -> None:
        """Start bumplessly: the first command is the measured differential."""
        difference = state.agonist - state.antagonist
        self._begin(state.position, difference)
        self.estimate = PairEstimate(0.0, -self._area * difference)

    def update(self, state: PairState, reference: PairReference, load: float = 0.0) -> PairCommand:
        """Return the setpoints for this period.

        Parameters
        ----------
        state, reference : PairState, PairReference
            What is, and what should be.
        load : float
            Force that the motion is known to take beyond the pair's own, N: what hangs on it.
        """
        _, position, agonist, antagonist = state
        wanted, velocity, acceleration = reference
        first, second, speed, disturbance, self.correction = self._step(
            position, agonist - antagonist, wanted, velocity, acceleration, load
        )
        self.estimate = new_tuple(PairEstimate, (speed, disturbance))
        return new_tuple(PairCommand, (first, second))

    @abstractmethod
    def _begin(self, position: float, difference: float) -> None:
        """Start at a measured position (m) and difference of the pressures (Pa)."""


AnyPairLaw = PairLaw[Any]
"""The law of a pair, whatever its settings."""


class Integral(PlainNumbers):
    """The integral of a law, which starts bumplessly and does not wind up.

    References
    ----------
    K. J. Åström, T. Hägglund, "Advanced PID control", ISA, 2006, chapter 3 (bumpless transfer,
    conditional integration).
    """

    def __init__(self) -> None:
        self.value = 0.0
        """In the unit of what it is added to."""
        self._started = False

    def reset(self, first: float) -> None:
        """Start so that the first `wish` is this."""
        self.value = first
        self._started = False

    def wish(self, direct: float) -> float:
        """Return the sum of what a law asks for directly and of the integral."""
        if not self._started:
            self._started = True
            self.value -= direct
        return direct + self.value

    def grow(self, step: float, error: float, beyond: float) -> None:
        """Add ``step * error``, unless that leads further `beyond` what can be had.

        Parameters
        ----------
        step : float
            Gain times period.
        error : float
            What is integrated.
        beyond : float
            On which side the wish was out of reach: its sign counts; 0 if it was not.
        """
        if beyond * error <= 0.0:
            self.value += step * error
