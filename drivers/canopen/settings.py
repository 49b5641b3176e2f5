"""What a profile says of one CAN bus with CANopen devices on it."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Interval, MinLen, Unit

from rig.hal import BusSettings, Endpoint


@dataclass(frozen=True, slots=True)
class CanBusSettings(BusSettings):
    """One CAN interface, and how the master behaves on it.

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
    master_id : int
        Node number under which the master sends its heartbeat.
    heartbeat : float
        Heartbeat period in both directions, s. The master's is sent from the cycle, so it
        stops when the cycle does.
    heartbeat_timeout : float
        After this silence a node takes its safe state, and the master raises a fault, s.
    sdo_timeout : float
        How long the master waits for an answer while it configures, s.
    boot_timeout : float
        How long the master waits for a node to appear or to change its state, s.
    sync : bool
        Send SYNC at the end of every cycle; False if another device on the bus sends it.
    max_load : float
        Highest share of the bus's time that the cycle may need, worst case.
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
    master_id: Annotated[int, Interval(ge=1, le=127)] = 127
    heartbeat: Annotated[float, Unit("s"), Interval(ge=1e-3, le=10.0)] = 0.05
    heartbeat_timeout: Annotated[float, Unit("s"), Interval(ge=2e-3, le=60.0)] = 0.15
    sdo_timeout: Annotated[float, Unit("s"), Gt(0)] = 0.3
    boot_timeout: Annotated[float, Unit("s"), Gt(0)] = 2.0
    sync: bool = True
    max_load: Annotated[float, Unit("1"), Interval(gt=0, le=1)] = 0.7
    receive_limit: Annotated[int, Ge(1)] = 256
    max_refused: Annotated[int, Ge(0)] = 3

    def __post_init__(self) -> None:
        if self.heartbeat_timeout < 2.0 * self.heartbeat:
            raise ValueError(
                f"heartbeat_timeout ({self.heartbeat_timeout:g} s) is less than two periods of "
                f"heartbeat ({self.heartbeat:g} s); one late heartbeat would stop the rig."
            )

    def endpoint(self) -> Endpoint:
        """Return the interface."""
        return Endpoint(self.interface, self.channel, self.bitrate)
