"""Laws of a pair whose step works on numbers alone: the same source runs as Python and compiled."""

from abc import abstractmethod
from typing import Any, ClassVar

from controllers.base import Chosen
from controllers.compiled import KernelMemory, PlainNumbers, change_constants
from controllers.cylinder.law import Output, PairLaw
from controllers.cylinder.types import PairModel

_REST = (0.0,) * 6


class PairNumbers(PlainNumbers):
    """The numbers of a pair's law, and its step of one period.

    Parameters
    ----------
    settings : object
        Of the law.
    model : PairModel
        The pair.
    period : float
        The loop's period, s.
    """

    @abstractmethod
    def __init__(self, settings: object, model: PairModel, period: float) -> None: ...

    @abstractmethod
    def reset(self, position: float, difference: float) -> None:
        """Start at a measured position (m) and difference of the pressures (Pa)."""

    @abstractmethod
    def step(
        self,
        measured: float,
        difference: float,
        wanted: float,
        wanted_velocity: float,
        wanted_acceleration: float,
        load: float,
    ) -> Output:
        """Advance by one period.

        Parameters
        ----------
        measured, difference : float
            Position of the pair, m, and agonist's over antagonist's pressure, Pa.
        wanted, wanted_velocity, wanted_acceleration : float
            Reference, m, m/s, m/s².
        load : float
            Force that the motion is known to take beyond the pair's own, N.
        """


class NumericPairLaw(PairLaw[Chosen]):
    """A law of a pair that runs as Python until `compile` is called."""

    Numbers: ClassVar[type[PairNumbers]]

    def __init__(self, settings: Chosen, model: PairModel, period: float) -> None:
        super().__init__(settings, model, period)
        self.numbers: PairNumbers = self.Numbers(settings, model, period)
        self._step = self.numbers.step
        self._memory: KernelMemory[PairNumbers] | None = None

    def compile(self) -> None:
        """Run compiled from now on, for a loop: in a third of the time, after seconds once."""
        self._memory = KernelMemory(self.numbers)
        self._step = self._memory.bind(self.Numbers.step)
        self._step(*_REST)  # the first call is what compiles
        self._memory.lay(self.numbers)

    def retune(self, settings: Chosen) -> None:
        """See `Law.retune`."""
        before = self.Numbers(self.settings, self.model, self.period)
        after = self.Numbers(settings, self.model, self.period)
        change_constants(self.numbers, before, after)
        if self._memory is not None:
            self._memory.change(before, after)
        self.settings = settings

    def _begin(self, position: float, difference: float) -> None:
        self.numbers.reset(position, difference)
        if self._memory is not None:
            self._memory.lay(self.numbers)


AnyNumericLaw = NumericPairLaw[Any]
"""Such a law, whatever its settings."""
