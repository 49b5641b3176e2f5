"""The port of a plant: what the simulation needs of the physics of a mechanism."""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, Protocol, Self, runtime_checkable


class Plant(Protocol):
    """The physics of one simulated mechanism.

    Made as ``Class(settings, seed)``, or ``Class(settings, seed, geometry)`` where the mechanism
    names a geometry (`Mechanism.geometry_of`). Simulated devices use further ports of it, which
    are between a driver's simulation and the plants that it runs on (`drivers.sim`).
    """

    channel_names: tuple[str, ...]
    """What devices may be wired to: chambers, rods, axes."""

    known_faults: tuple[str, ...]
    """Names that `inject` understands; empty if nothing of it breaks."""

    truth_columns: Sequence[tuple[str, str]]
    """Names and SI units of what `truth` returns."""

    @abstractmethod
    def advance(self, t: float) -> None:
        """Integrate up to time `t`, s."""

    @abstractmethod
    def truth(self) -> tuple[float, ...]:
        """Return the true state, which no device measures, one value for each column."""

    def powered(self) -> Mapping[str, bool]:
        """Return of each drive, by its axis, whether it has torque; default: there are none.

        Nothing of it is logged: campaigns of faults keep it beside the truth.
        """
        return {}

    @abstractmethod
    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now.

        Raises
        ------
        ValueError
            There is no such fault.
        """


@runtime_checkable
class MeasuredPlant(Protocol):
    """A plant that tells any sensor what there is at a channel.

    A device whose driver brings no simulation of its own measures by it; on another plant such a
    device reads 0.
    """

    def channel_value(self, channel: int) -> float:
        """Return what a sensor at one of `Plant.channel_names` measures now, SI."""
        return 0.0


@runtime_checkable
class HandledPlant(Plant, Protocol):
    """A plant that simulated hands can move, as an acceptance test asks a person to."""

    @abstractmethod
    def pull(self, channel: str, by: float) -> None:
        """Move what a channel measures a little by hand, without energy: SI, out is positive.

        A hand moves nothing beyond a mechanical end.
        """


@runtime_checkable
class AiryPlant(Plant, Protocol):
    """A plant with rods that air moves, as a person handles it in an acceptance test."""

    @abstractmethod
    def put_back(self) -> None:
        """Put all that moves where it was at first, at rest and without energy."""

    @abstractmethod
    def bubbling(self) -> tuple[str, ...]:
        """Return the channels where soap water bubbles now."""


class RestorablePlant(Plant, Protocol):
    """A plant that can be taken back to where it was, to go another way from there.

    That it can is said in its row, `PlantModel.is_restorable`.
    """

    time: float
    """How far it has been integrated, s."""

    @abstractmethod
    def snapshot(self) -> object:
        """Return all that moves, as it is now."""

    @abstractmethod
    def restore(self, snapshot: object) -> None:
        """Go back to a snapshot of this plant."""


class LentPlant(NamedTuple):
    """A plant with its devices as one compiled function, for loops that are compiled as a whole.

    Parameters
    ----------
    exchange : callable
        ``exchange(memory, setpoints, seen, truth)`` writes into `seen` what the devices measure
        now (the extensions of all rods in m, then the pressures of all chambers in Pa gauge),
        takes `setpoints` (Pa gauge), integrates over one period, and writes into `truth` what is
        true then of the axes that are controlled, SI. Compiled functions may call it.
    memory : tuple
        What it works on and changes in place: arrays, and tuples of arrays.
    channels : int
        How many rods and chambers it has.
    """

    exchange: Callable[..., None]
    memory: tuple[object, ...]
    channels: int


class LendingPlant(Plant, Protocol):
    """A plant that lends its kernel to loops that are compiled as a whole."""

    @abstractmethod
    def lend(
        self, period: float, rod_step: float, pressure_step: float, seed: int
    ) -> tuple[Callable[..., None], tuple[object, ...]]:
        """Return the first two of a `LentPlant`; from then on they alone advance the plant.

        Its supply is open.

        Parameters
        ----------
        period : float
            The loop's, s.
        rod_step, pressure_step : float
            The finest steps of the devices, m and Pa.
        seed : int
            Of the devices' noise.
        """


class PhysicsSettings(Protocol):
    """The settings of a plant. Inherit it: what has a default need not be written."""

    def variant(self) -> str | None:
        """Return which kind of this plant it is, for people; None: there is one kind only."""
        return None

    def perturbed(self, *, friction: float, stribeck: float, wire_offset: float) -> Self:
        """Return the settings of a rig that differs from its profile.

        What the plant has not is left alone.

        Parameters
        ----------
        friction : float
            By which share all friction is greater.
        stribeck : float
            By which share the seals' Stribeck velocity is greater.
        wire_offset : float
            By how much more the rods are extended when the wires are taut, m.
        """
        return self


class LendingSettings(PhysicsSettings, Protocol):
    """The settings of a plant that lends its kernel."""

    @abstractmethod
    def believed(self, told: Mapping[str, float]) -> Self:
        """Return the settings of a plant that is as the laws are told that the rig is.

        Parameters
        ----------
        told : mapping
            Numbers of the mechanism's model by name, SI (`Mechanism.model_of`).
        """
