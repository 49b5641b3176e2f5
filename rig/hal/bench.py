"""The seam between `rig tune` and a mechanism: a loop that gains are tried on."""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, Protocol

from rig.hal.closed_loop import ClosedLoop
from rig.hal.plant import LentPlant

Lend = Callable[[Mapping[str, float], int], LentPlant]
"""Lends a plant that is as laws are told (numbers of the model by name, SI), with a seed."""


class Unknown(NamedTuple):
    """A property of a rig that gains have to bear, whatever it is within bounds.

    Parameters
    ----------
    name : str
        For people.
    numbers : tuple of str
        Of the mechanism's model, which vary together.
    unit : str
        Empty: they are multiplied by what is drawn. Else it is added, in this unit.
    guessed, measured : tuple of float
        Least and greatest, where the profile is believed and where a calibration has measured it.
    measured_by : str
        What a calibration of the mechanism has replaced then: the key of its section.
    """

    name: str
    numbers: tuple[str, ...]
    unit: str
    guessed: tuple[float, float]
    measured: tuple[float, float]
    measured_by: str


class Trial(NamedTuple):
    """The outcome of a law on one plant.

    Parameters
    ----------
    errors : mapping of str to float
        By the stretch of the motion: of the true position from the reference, rms, SI.
    hunting : float
        Greatest true motion, peak to peak, while the reference rests and the rig has had the time
        to come to rest, SI.
    reversals : float
        Of the setpoint that turns round most often, 1/s.
    strayed : float
        Greatest error that lasts until the program would stop the rig for it, over its limit.
    lasted : float
        Share of the motion until the rig was lost; 1 if it never was.
    """

    errors: Mapping[str, float]
    hunting: float
    reversals: float
    strayed: float
    lasted: float


class TuningBench(Protocol):
    """Closed loops of one rig and one law, for many settings of the law.

    Made as ``Class(settings, law, period, lend, motions)``: the mechanism's settings, the class of
    the law, the loop's period in seconds, who lends plants, and the motions to tune for;
    without any, it takes some of its own.
    """

    unit: str
    """Of errors and hunting."""

    unknowns: Sequence[Unknown]
    """What gains have to bear."""

    duration: float
    """How long a trial takes on the rig, s."""

    @abstractmethod
    def __init__(
        self, settings: object, law: type, period: float, lend: Lend, motions: Sequence[object] = ()
    ) -> None: ...

    @abstractmethod
    def told(self) -> dict[str, float]:
        """Return the numbers of the model that laws are told, SI."""

    def check(self, chosen: object) -> None:
        """Raise a ValueError if a law cannot be tried with such settings, whatever its gains."""

    @abstractmethod
    def trial(self, chosen: object, true: Mapping[str, float], seed: int) -> Trial:
        """Run a law on a plant.

        Parameters
        ----------
        chosen : object
            Settings of the law.
        true : mapping
            The plant's numbers, as `told` names them.
        seed : int
            Of what is drawn.

        Raises
        ------
        ValueError
            The law refuses these settings.
        """

    @abstractmethod
    def margins(
        self, chosen: object, plants: Sequence[Mapping[str, float]]
    ) -> Sequence[ClosedLoop]:
        """Return the margins of the loop that a law closes around each plant."""

    def measured(
        self, chosen: object, plants: Sequence[tuple[Mapping[str, float], int]]
    ) -> Sequence[ClosedLoop] | None:
        """Return the margins that `rig margins` would measure on each plant, which it shakes.

        A loop that cannot be told has an infinite sensitivity. None: nothing measures loops of
        this rig, and the linear `margins` have the word.

        Parameters
        ----------
        chosen : object
            Settings of the law.
        plants : sequence of (mapping, int)
            Numbers of each as `told` names them, and the seed of what is drawn.
        """
        return None
