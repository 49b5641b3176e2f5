"""The simulated world as whoever breaks it on purpose sees it."""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from typing import Final, NamedTuple, Protocol

from rig.hal.plant import Plant

BY_CHANNEL: Final = frozenset({
    "anchor_slipped", "blocked", "brake_released", "leak", "output_stuck", "regulator_closed",
    "regulator_open", "regulator_stuck", "valve_closed", "valve_open", "valve_stuck", "wire_break",
    "wire_cut", "wire_slack",
})  # fmt: skip
"""Faults whose value is the number of a channel, counted from 0; with a channel's name before it,
as in ``agonist.leak``, the value of a fault says how much."""


class Frames(NamedTuple):
    """The CAN identifiers of a device's process data.

    Parameters
    ----------
    bus : str
        Where they are sent.
    to_device, from_device : tuple of int
        Setpoints, and what it measures.
    alive : tuple of int
        By which it says that it lives, and by which the master does.
    """

    bus: str
    to_device: tuple[int, ...]
    from_device: tuple[int, ...]
    alive: tuple[int, ...]


class BreakableWorld(Protocol):
    """A world in virtual time that can be broken on purpose."""

    time: float
    plant: Plant

    @abstractmethod
    def advance(self, t: float) -> None:
        """Let time pass up to `t`, s; what the program has sent arrives."""

    @property
    @abstractmethod
    def known_faults(self) -> Mapping[str, tuple[str, ...]]:
        """Names that `inject` understands, of each device, each bus and the plant."""

    @abstractmethod
    def inject(self, device: str, fault: str, value: float | None = None) -> None:
        """Make a fault happen now.

        Raises
        ------
        ValueError
            There is no such device, it has no such fault, or the value does not fit.
        """

    @abstractmethod
    def frames_of(self, device: str) -> Frames | None:
        """Return the identifiers of a device's frames now; None if it has no CAN frames."""

    @abstractmethod
    def disturb(
        self,
        bus: str,
        kind: str,
        can_id: int,
        value: float,
        changed: Callable[[], None] | None = None,
    ) -> Callable[[], None]:
        """Have something happen to every frame of an identifier, until what is returned is called.

        Parameters
        ----------
        bus : str
            Its name.
        kind : str
            ``drop``, ``delay``, ``duplicate``, ``truncate``, ``corrupt``, ``reorder`` or ``spoof``.
        can_id : int
            Of the frames, in whichever direction they go.
        value : float
            What the kind takes: a delay in s, bytes that are left, a byte's place.
        changed : callable, optional
            Called for each such frame that says something else than the one before it.
        """
