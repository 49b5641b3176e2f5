"""Control laws of the crank: pure functions of state, reference and their own memory."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Unit

from controllers.base import Law
from crank_rig.crank.types import CrankCommand, CrankModel, CrankReference, CrankState


@dataclass(frozen=True, slots=True)
class IndependentSettings:
    """The law has nothing to set."""


class Independent(Law[IndependentSettings, CrankModel, CrankReference, CrankState, CrankCommand]):
    """Each crank follows its own reference, whatever the other one does."""

    Settings = IndependentSettings

    def reset(self, state: CrankState) -> None:
        """There is nothing to forget."""

    def update(self, state: CrankState, reference: CrankReference) -> CrankCommand:
        """Return the reference."""
        return CrankCommand(reference.positions, reference.velocities)


@dataclass(frozen=True, slots=True)
class CrossCoupledSettings:
    """How hard the cranks are kept in step.

    Parameters
    ----------
    gain : float
        Trim per second for a twist of the rod, 1/s.
    max_trim : float
        The greatest trim of a crank, rad.
    """

    gain: Annotated[float, Unit("1/s"), Ge(0)] = 5.0
    max_trim: Annotated[float, Unit("rad"), Gt(0)] = 0.05


class CrossCoupled(Law[CrossCoupledSettings, CrankModel, CrankReference, CrankState, CrankCommand]):
    """Trims both references against each other until the rod is no longer strained.

    References
    ----------
    Y. Koren, "Cross-coupled biaxial computer control for manufacturing systems", J. Dyn. Syst.
    Meas. Control 102(4), 1980: each axis is corrected by the error that both make together.
    """

    Settings = CrossCoupledSettings

    def __init__(self, settings: CrossCoupledSettings, model: CrankModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._step = settings.gain * period
        self._most = settings.max_trim
        self._rod_zero = model.rod_zero
        self._trim = 0.0

    def reset(self, state: CrankState) -> None:
        """Start without a trim: the first command is the reference, where the cranks are."""
        self._trim = 0.0

    def update(self, state: CrankState, reference: CrankReference) -> CrankCommand:
        """Return the reference, trimmed by what the cranks have been out of step."""
        left, right = state.positions
        trim = self._trim + self._step * (right - left - self._rod_zero)
        self._trim = min(max(trim, -self._most), self._most)
        left, right = reference.positions
        return CrankCommand((left + self._trim, right - self._trim), reference.velocities)
