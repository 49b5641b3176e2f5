"""What a profile says of a CAN interface, whatever is spoken on it."""

from dataclasses import dataclass, field
from math import inf
from typing import Annotated

from annotated_types import Interval, MinLen, Unit

from drivers.can.interface_names import interface_trouble
from rig.hal import BusSettings, Endpoint


@dataclass(frozen=True, slots=True)
class CanInterfaceSettings(BusSettings):
    """One CAN interface.

    Parameters
    ----------
    interface : str
        A python-can interface: ``socketcan``, ``virtual``, ``pcan``, ``kvaser``, ``slcan``, …
    channel : str
        What the interface calls the bus: ``can0``, ``PCAN_USBBUS1``, ``/dev/ttyACM0``, …
    bitrate : int
        Of the bus, bit/s. SocketCAN's is set with ``ip link``, outside the program.
    options : dict of str to str, int, float or bool
        More arguments for the interface's python-can class.
    boot_timeout : float
        How long the master waits for a node to appear or to change its state, s.
    max_load : float
        Highest share of the bus's time that may be needed, worst case.
    receive_limit : int
        Most frames taken in one cycle; what is beyond waits for the next one, so that a
        device that floods the bus cannot stop the loop.
    max_refused : int
        Cycles in a row in which the interface may refuse a frame before this is a fault.
    """

    interface: Annotated[str, MinLen(1)]
    channel: Annotated[str, MinLen(1)]
    bitrate: Annotated[int, Unit("bit/s"), Interval(ge=10_000, le=1_000_000)] = 1_000_000
    options: dict[str, str | int | float | bool] = field(default_factory=dict)
    boot_timeout: Annotated[float, Unit("s"), Interval(ge=1e-3, le=60.0)] = 2.0
    max_load: Annotated[float, Unit("1"), Interval(gt=0, le=1)] = 0.7
    receive_limit: Annotated[int, Interval(ge=1, le=10_000)] = 256
    max_refused: Annotated[int, Interval(ge=0, le=100)] = 3

    def endpoint(self) -> Endpoint:
        """Return the interface."""
        return Endpoint(self.interface, self.channel, self.bitrate)

    def trouble(self) -> str | None:
        """Say why this is no interface that a file may name."""
        return interface_trouble(self.interface, self.channel, self.options)

    @property
    def sync(self) -> bool:
        """Whether the master sends SYNC."""
        return False

    @property
    def heartbeat(self) -> float:
        """Period of all heartbeats, s; infinite if the master sends none."""
        return inf
