"""The contract of a step of the acceptance test: what it does, expects and has measured."""

from abc import abstractmethod
from math import inf
from typing import NamedTuple, Protocol

from rig.commissioning.site import Site
from rig.hal import DeviceError
from rig.hal.formats import format_quantity


class MeasuredValue(NamedTuple):
    """A measured value and the bounds that it was held against.

    Parameters
    ----------
    name : str
        What was measured.
    value : float
        SI.
    unit : str
        Of SI.
    low, high : float
        It passes within these.
    """

    name: str
    value: float
    unit: str
    low: float = -inf
    high: float = inf

    @property
    def passed(self) -> bool:
        """Whether it is within its bounds."""
        return self.low <= self.value <= self.high

    def __str__(self) -> str:
        ends = [
            f"{word} {format_quantity(bound, self.unit)}"
            for word, bound in (("at least", self.low), ("at most", self.high))
            if abs(bound) < inf
        ]
        expected = f" ({', '.join(ends)})" if ends else ""
        return f"{self.name}: {format_quantity(self.value, self.unit)}{expected}"


class Defect(DeviceError):
    """A step has found something wrong with the rig; nothing may be energised any more."""


class StepResult(NamedTuple):
    """The findings of a step.

    Parameters
    ----------
    measured : tuple of MeasuredValue
        Every value; all of them passed.
    facts : dict
        What else belongs into the record: serial numbers, objects that were read back.
    said : str
        In a sentence; why nothing was measured, if nothing was.
    """

    measured: tuple[MeasuredValue, ...] = ()
    facts: dict[str, object] = {}  # noqa: RUF012 -- a default that nobody changes
    said: str = ""


class AcceptanceStep(Protocol):
    """One step. It starts from a rig without energy and leaves it so."""

    name: str
    """What the command line and the record call it."""
    does: str
    """What will happen, for the operator."""
    expects: str
    """What is expected, for the operator."""

    @abstractmethod
    def perform(self, site: Site) -> StepResult:
        """Do it.

        Raises
        ------
        Defect
            It found something; the sentence names it.
        DeviceError
            The rig's own checks found something.
        """


def require(passes: bool, where: str, defect: str) -> None:
    """Raise unless something is as it should be.

    Raises
    ------
    Defect
    """
    if not passes:
        raise Defect(where, defect)


def require_within(where: str, measured: MeasuredValue, defect: str) -> MeasuredValue:
    """Return a value that is within its bounds.

    Raises
    ------
    Defect
        It is not.
    """
    require(measured.passed, where, f"{defect}; {measured}")
    return measured
