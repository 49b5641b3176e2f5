"""What a CAN bus with CANopen devices has to carry, and how often its master beats."""

from collections.abc import Sequence

from drivers.can.load import check_bus_load
from drivers.canopen.settings import CanBusSettings
from rig.hal import BusLoad, DriverSettings


def check_canopen_load(
    name: str, bus: CanBusSettings, devices: Sequence[tuple[str, DriverSettings]], rate: float
) -> BusLoad:
    """Return the load of a bus; see `drivers.can.load.check_bus_load`.

    Raises
    ------
    ConfigurationError
        It is too much, or at this rate the master beats too seldom for its nodes.
    """
    bus.check_cycle(name, 1.0 / rate)
    return check_bus_load(name, bus, devices, rate)
