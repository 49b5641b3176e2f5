"""The bus seam: what a driver needs of a CAN bus, and of anything exchanged cyclically."""

from collections.abc import Iterable, Sequence
from typing import Protocol


class Frame(Protocol):
    """A classic CAN or CAN FD frame; `can.Message` satisfies it as it is."""

    arbitration_id: int
    is_error_frame: bool
    is_remote_frame: bool
    is_extended_id: bool

    @property
    def data(self) -> bytes | bytearray:
        """0 … 8 bytes, of CAN FD up to 64."""
        ...


class CanBus(Protocol):
    """A CAN interface; `can.BusABC` satisfies it as it is."""

    def send(self, msg: Frame, timeout: float | None = None) -> None:
        """Queue one frame; raise `can.CanError` or `OSError` if the interface refuses it."""
        ...

    def recv(self, timeout: float | None = None) -> Frame | None:
        """Return the next received frame, or None after `timeout` seconds (0: at once)."""
        ...

    def shutdown(self) -> None:
        """Release the interface."""
        ...


class FastCanBus(Protocol):
    """A CAN interface as the cycle uses it: identifiers with flags, bytes, and no frame objects.

    SocketCAN's raw socket offers all of it; `drivers.can.fast_path` makes it of any `CanBus`.
    An identifier bears SocketCAN's flags for extended, remote and error frames.
    """

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the waiting frames, at most `limit`, without waiting."""
        ...

    def send_data(self, can_id: int, data: bytes) -> None:
        """Send one frame; raise `can.CanError` or `OSError` if the interface refuses it."""
        ...

    def backlog(self) -> int:
        """Return how many frames wait that the interface has not taken yet; 0 if it cannot tell."""
        ...

    def count_dropped(self) -> int:
        """Return how many frames were lost since nobody took them in time; 0 if it cannot tell."""
        ...

    def accept(self, can_ids: Iterable[int]) -> None:
        """Let only these identifiers through, where the interface can filter."""
        ...

    def count_others(self) -> int:
        """Return how many frames `accept` held back; 0 if it cannot tell."""
        ...

    def shutdown(self) -> None:
        """Release the interface."""
        ...


class CyclicBus(Protocol):
    """A bus as the cycle sees it: its drivers' I/O happens in these calls and nowhere else."""

    name: str

    def open(self) -> None:
        """Open the interface."""
        ...

    def receive(self, now: float) -> None:
        """Take every waiting frame to the driver that it belongs to."""
        ...

    def transmit(self, now: float) -> None:
        """Send this cycle's setpoints, SYNC, and the heartbeat if it is due."""
        ...

    def check(self, now: float) -> None:
        """Raise if the bus itself is not well.

        Raises
        ------
        DeviceFault
            The interface is down, off the bus, or refuses frames.
        """
        ...

    def make_safe(self) -> None:
        """Send the safe setpoints of every driver on this bus now. Never raises."""
        ...

    def close(self) -> None:
        """Stop the nodes and release the interface. Idempotent."""
        ...

    def statistics(self) -> dict[str, float]:
        """Return counters for the run's manifest: frames in, out, unknown, lost."""
        ...


Buses = Sequence[CyclicBus]
