"""Cascade of position and velocity loops on an observer that is fed with measured pressures."""

from controllers.compiled import KernelMemory
from controllers.cylinder.cascade_law import CascadeLaw
from controllers.cylinder.cascade_settings import CascadeSettings
from controllers.cylinder.law import PairLaw
from controllers.cylinder.types import PairModel

_REST = (0.0,) * 6


class Cascade(PairLaw[CascadeSettings]):
    """Position over velocity over force, with an observer, feedforward, integral and lead.

    The law itself is `CascadeLaw`: numbers, which run as Python until `compile` is called.

    Notes
    -----
    Taking its parts away one by one on the simulated pair shows that lead, integral, friction
    feedforward and a fast observer fed with the measured force carry it.
    """

    Settings = CascadeSettings

    def __init__(self, settings: CascadeSettings, model: PairModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._law = CascadeLaw(settings, model, period)
        self._step = self._law.step
        self._memory: KernelMemory[CascadeLaw] | None = None

    def compile(self) -> None:
        """Run compiled from now on, for a loop: in a third of the time, after seconds once."""
        self._memory = KernelMemory(self._law)
        self._step = self._memory.bind(CascadeLaw.step)
        self._step(*_REST)  # the first call is what compiles
        self._memory.lay(self._law)

    def _begin(self, position: float, difference: float) -> None:
        self._law.reset(position, difference)
        if self._memory is not None:
            self._memory.lay(self._law)
