"""A CAN bus with CANSimple axes as the cycle sees it: one place for all its I/O.

There is no network management here: axes send by their own clocks, and the setpoints that
feed their watchdogs are the only sign of life of the master.
"""

from collections.abc import Callable
from math import inf

from drivers.can.cyclic import CyclicCanBus
from drivers.can.frame import REMOTE_FLAG
from drivers.odrive.settings import OdriveBusSettings
from rig.hal import Clock, FastCanBus


class OdriveBus(CyclicCanBus):
    """The master of CANSimple axes on one CAN interface; satisfies `rig.hal.CyclicBus`.

    What still moves when it is closed loses its setpoints, and its watchdog takes the torque away.
    Parameters are those of `CyclicCanBus`.

    Attributes
    ----------
    received_before : float
        When frames were received before the last time, s: what came then was sent after it.
    """

    def __init__(
        self,
        name: str,
        settings: OdriveBusSettings,
        open_bus: Callable[[], FastCanBus],
        clock: Clock,
        period: float | None = None,
    ) -> None:
        super().__init__(name, settings, open_bus, clock, period)
        self.settings = settings
        self.received_before = -inf
        self._received = -inf

    def _owners(self, can_id: int) -> str:
        return f"joints have axis {can_id >> 5}"

    def receive(self, now: float) -> None:
        """Take every waiting frame to its handler. Hot path."""
        self.received_before, self._received = self._received, now
        super().receive(now)

    def transmit(self, now: float) -> None:
        """Send this cycle's setpoints, which feed the watchdogs. Hot path."""
        self._send_cyclic()

    def make_safe(self) -> None:
        """Send the setpoints that the drivers left, which are their safe ones. Never raises."""
        self._send_cyclic()

    def request(self, can_id: int) -> None:
        """Ask for a frame with a remote frame; errors as `send`."""
        self.send(can_id | REMOTE_FLAG, b"")
