"""What an emulated bus needs of the nodes on it, whatever they speak."""

from collections.abc import Callable
from typing import Protocol

Send = Callable[[int, bytes], None]


class BusNode(Protocol):
    """A device on an emulated CAN bus."""

    name: str
    node_id: int
    send: Send
    """Takes CAN id and data of each frame that leaves the node; the bus sets it."""
    due: float
    """When `tick` has something to do at the latest, s."""
    now: float
    """The time that the node was last told, s."""
    listens_anew: Callable[[], None]
    """Called when the node hears other identifiers than before; the bus sets it."""

    def hears(self, can_id: int) -> bool:
        """Return whether `receive` does anything with data frames of this identifier now."""

    def receive(
        self, can_id: int, data: bytes, now: float, *, extended: bool = False, remote: bool = False
    ) -> None:
        """Take a frame from the bus; what is not for this node is ignored."""

    def tick(self, now: float) -> None:
        """Do what is due at time `now`, s."""

    @property
    def transmit_ids(self) -> tuple[int, ...]:
        """CAN ids of the process data that the node sends now."""

    @property
    def receive_ids(self) -> tuple[int, ...]:
        """CAN ids of the process data that the node takes now."""

    @property
    def alive_ids(self) -> tuple[int, ...]:
        """CAN ids by which the node says that it lives."""

    def add_fault(
        self,
        fault: str,
        action: Callable[[float | None], None],
        repair: Callable[[], None] | None = None,
    ) -> None:
        """Make a fault known by name, with what undoes it."""

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` accepts."""

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now."""
