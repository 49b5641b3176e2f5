"""What a profile says of one CAN bus with CANopen devices on it."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Interval, Unit

from drivers.can.bus_settings import CanInterfaceSettings


@dataclass(frozen=True, slots=True)
class CanBusSettings(CanInterfaceSettings):
    """One CAN interface, and how the master behaves on it.

    Parameters
    ----------
    master_id : int
        Node number under which the master sends its heartbeat.
    heartbeat : float
        Heartbeat period in both directions, s. The master's is sent from the cycle, so it
        stops when the cycle does.
    heartbeat_timeout : float
        After this silence a node takes its safe state, and the master raises a fault, s.
    sdo_timeout : float
        How long the master waits for an answer while it configures, s.
    sync : bool
        Send SYNC at the end of every cycle; False if another device on the bus sends it.
    """

    master_id: Annotated[int, Interval(ge=1, le=127)] = 127
    heartbeat: Annotated[float, Unit("s"), Interval(ge=1e-3, le=10.0)] = 0.05
    heartbeat_timeout: Annotated[float, Unit("s"), Interval(ge=2e-3, le=60.0)] = 0.15
    sdo_timeout: Annotated[float, Unit("s"), Interval(ge=1e-3, le=10.0)] = 0.3
    sync: bool = True

    def __post_init__(self) -> None:
        if self.heartbeat_timeout < 2.0 * self.heartbeat:
            raise ValueError(
                f"heartbeat_timeout ({self.heartbeat_timeout:g} s) is less than two periods of "
                f"heartbeat ({self.heartbeat:g} s); one late heartbeat would stop the rig."
            )
