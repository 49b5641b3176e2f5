"""What a profile says of one CAN bus with CANopen devices on it."""

from dataclasses import dataclass
from math import ceil
from typing import Annotated

from annotated_types import Interval, Unit

from drivers.can.bus_settings import CanInterfaceSettings
from drivers.can.milliseconds import check_milliseconds
from rig.hal import ConfigurationError
from rig.hal.rules import Rules


@dataclass(frozen=True, slots=True)
class CanBusSettings(CanInterfaceSettings):
    """One CAN interface, and how the master behaves on it.

    Parameters
    ----------
    master_id : int
        Node number under which the master sends its heartbeat.
    heartbeat : float
        Heartbeat period in both directions, s. The master's is sent from the cycle, so it
        stops when the cycle does. In whole milliseconds, as the nodes are told it (0x1017).
    heartbeat_timeout : float
        After this silence a node takes its safe state, and the master raises a fault, s: in whole
        milliseconds (0x1016).
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
        with Rules() as rule:
            rule.of(check_milliseconds, "heartbeat", self.heartbeat, "object 0x1017")
            rule.of(
                check_milliseconds, "heartbeat_timeout", self.heartbeat_timeout, "object 0x1016"
            )
            if self.heartbeat_timeout < 2.0 * self.heartbeat:
                rule.broken(
                    f"heartbeat_timeout ({self.heartbeat_timeout:g} s) is less than two periods of "
                    f"heartbeat ({self.heartbeat:g} s); one late heartbeat would stop the rig."
                )

    def check_cycle(self, name: str, period: float) -> None:
        """Raise if cycles let the master beat too seldom for the nodes: it beats in a cycle.

        Parameters
        ----------
        name : str
            The bus's name in the profile.
        period : float
            Of the cycle, s.

        Raises
        ------
        ConfigurationError
        """
        between = ceil(self.heartbeat / period - 1e-9) * period
        least = between + period
        if self.heartbeat_timeout < least - 1e-9:
            raise ConfigurationError(
                f"buses.{name}.heartbeat_timeout ({self.heartbeat_timeout:g} s) is less than what "
                f"lies between two heartbeats of the master, {between:g} s in cycles of "
                f"{period:g} s, and a cycle more; one late cycle would stop the rig; give "
                f"{least:g} s at least, or a higher loop.rate"
            )
