"""The bus seam: what a driver needs of a CAN bus, and of anything exchanged cyclically."""

from collections.abc import Iterable, Sequence
from math import floor, log10
from typing import NamedTuple, Protocol

from rig.hal.errors import ConfigurationError


class Frame(Protocol):
    """A classic CAN or CAN FD frame; `can.Message` satisfies it as it is."""

    arbitration_id: int
    is_error_frame: bool
    is_remote_frame: bool
    is_extended_id: bool

    @property
    def data(self) -> bytes | bytearray:
        """0 … 8 bytes, of CAN FD up to 64."""


class CanBus(Protocol):
    """A CAN interface; `can.BusABC` satisfies it as it is."""

    def send(self, msg: Frame, timeout: float | None = None) -> None:
        """Queue one frame; raise `can.CanError` or `OSError` if the interface refuses it."""

    def recv(self, timeout: float | None = None) -> Frame | None:
        """Return the next received frame, or None after `timeout` seconds (0: at once)."""

    def fileno(self) -> int:
        """Return the descriptor to wait for; raise `NotImplementedError` without one."""

    def shutdown(self) -> None:
        """Release the interface."""


class FastCanBus(Protocol):
    """A CAN interface as the program uses it: identifiers with flags, bytes, no frame objects.

    SocketCAN's raw socket offers all of it; `drivers.can.fast_path` makes it of any `CanBus`, once,
    when an interface is opened. An identifier bears SocketCAN's flags for extended, remote and
    error frames. Inherit it: what has a default need not be written.
    """

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the waiting frames, at most `limit`, without waiting."""

    def send_data(self, can_id: int, data: bytes) -> None:
        """Send one frame; raise `can.CanError` or `OSError` if the interface refuses it."""

    def backlog(self) -> int:
        """Return how many frames wait that the interface has not taken yet; 0 if it cannot tell."""
        return 0

    def count_dropped(self) -> int:
        """Return how many frames were lost since nobody took them in time; 0 if it cannot tell."""
        return 0

    def accept(self, can_ids: Iterable[int]) -> None:
        """Let only these identifiers through, where the interface can filter."""
        return

    def count_others(self) -> int:
        """Return how many frames `accept` held back; 0 if it cannot tell."""
        return 0

    def fileno(self) -> int:
        """Return the descriptor that becomes readable when a frame comes; -1: there is none."""
        return -1

    def shutdown(self) -> None:
        """Release the interface."""


class FrameLoad(NamedTuple):
    """One frame's share of a bus's time.

    Attributes
    ----------
    name : str
        Device and frame.
    size : int
        Data bytes.
    rate : float
        How often it is sent, Hz.
    load : float
        Its share, 0 … 1.
    """

    name: str
    size: int
    rate: float
    load: float


class BusLoad(NamedTuple):
    """The load of a bus.

    Attributes
    ----------
    total : float
        Share of the bus's time, 0 … 1.
    frames : tuple of FrameLoad
        The largest first.
    """

    total: float
    frames: tuple[FrameLoad, ...]

    @classmethod
    def of(cls, frames: Iterable[FrameLoad]) -> "BusLoad":
        """Return the load that frames make together."""
        largest_first = tuple(sorted(frames, key=lambda frame: -frame.load))
        return cls(sum(frame.load for frame in largest_first), largest_first)

    def check(self, most: float, bus: str, remedy: str) -> "BusLoad":
        """Return it if it is not too much.

        Parameters
        ----------
        most : float
            The greatest permitted, 0 … 1.
        bus : str
            How the message starts: the bus, its rates, and what kind of load that is.
        remedy : str
            What to do about it.

        Raises
        ------
        ConfigurationError
            It is too much; the message lists what fills the bus.
        """
        if self.total <= most:
            return self
        raise ConfigurationError(
            f"{bus} is {100.0 * self.total:.1f} %, at most {100.0 * most:g} % is allowed: "
            f"{100.0 * (self.total - most):.1f} % too much. {remedy}:\n{self.table()}"
        )

    def fitting(self, rate: float, at_rest: float, most: float) -> str:
        """Return which loop's rate would fit, in words.

        Parameters
        ----------
        rate : float
            Of the loop, Hz, with which the load is this one.
        at_rest : float
            The load of what is sent however fast the loop is, 0 … 1.
        most : float
            The greatest permitted, 0 … 1.
        """
        if at_rest >= most:
            return "no rate would fit"
        found = rate * (most - at_rest) / (self.total - at_rest)
        step = 10.0 ** (floor(log10(found)) - 1)  # two digits, rounded down: it has to fit
        return f"{floor(found / step) * step:g} Hz would fit"

    def table(self) -> str:
        """Return the frames as lines of text."""
        width = max((len(frame.name) for frame in self.frames), default=0)
        rows = [
            f"  {frame.name:{width}}  {frame.size} bytes at {frame.rate:>6g} Hz  "
            f"{100.0 * frame.load:5.1f} %"
            for frame in self.frames
        ]
        return "\n".join(rows)


class CyclicBus(Protocol):
    """A bus as the cycle sees it: its drivers' I/O happens in these calls and nowhere else."""

    name: str

    def open(self) -> None:
        """Open the interface."""

    def expect_alone(self, duration: float) -> None:
        """Only listen for so long (s), and raise if somebody else is the bus's master.

        Raises
        ------
        ConnectionFailed
            Another master was heard.
        """

    def receive(self, now: float) -> None:
        """Take every waiting frame to the driver that it belongs to."""

    def transmit(self, now: float) -> None:
        """Send this cycle's setpoints, SYNC, and the heartbeat if it is due."""

    def check(self, now: float) -> None:
        """Raise if the bus itself is not well.

        Raises
        ------
        DeviceFault
            The interface is down, off the bus, or refuses frames.
        """

    def make_safe(self) -> None:
        """Send the safe setpoints of every driver on this bus now. Never raises."""

    def close(self) -> None:
        """Stop the nodes and release the interface. Idempotent."""

    def statistics(self) -> dict[str, float]:
        """Return counters for the run's manifest: frames in, out, unknown, lost."""


Buses = Sequence[CyclicBus]
