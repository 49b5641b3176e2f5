"""Control laws: pure functions of state, reference and their own memory."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Unit

from controllers.base import Law
from rig.scaffolding.templates.mechanism.types import (
    MyRigCommand,
    MyRigModel,
    MyRigReference,
    MyRigState,
)


@dataclass(frozen=True, slots=True)
class TrimmedSettings:
    """Gain and bound of the trim.

    Parameters
    ----------
    gain : float
        Trim per second for an error, 1/s.
    max_trim : float
        The greatest trim, rad.
    """

    gain: Annotated[float, Unit("1/s"), Ge(0)] = 4.0
    max_trim: Annotated[float, Unit("rad"), Gt(0)] = 0.05


class Trimmed(Law[TrimmedSettings, MyRigModel, MyRigReference, MyRigState, MyRigCommand]):
    """Sends the reference, and more of it by the integral of what the drives leave."""

    Settings = TrimmedSettings

    def __init__(self, settings: TrimmedSettings, model: MyRigModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._step = settings.gain * period
        self._most = settings.max_trim
        self._trim: tuple[float, ...] = ()

    def reset(self, state: MyRigState) -> None:
        """Start without a trim: the first command is where the axis is."""
        self._trim = (0.0,) * len(state.positions)

    def update(self, state: MyRigState, reference: MyRigReference) -> MyRigCommand:
        """Return the trimmed reference."""
        step, most = self._step, self._most
        rows = zip(self._trim, reference.positions, state.positions, strict=True)
        self._trim = tuple(
            min(max(trim + step * (wanted - there), -most), most) for trim, wanted, there in rows
        )
        positions = zip(reference.positions, self._trim, strict=True)
        return MyRigCommand(
            tuple(wanted + trim for wanted, trim in positions), reference.velocities
        )
