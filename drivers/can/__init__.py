"""CAN interfaces behind one seam, `rig.hal.CanBus`."""

from drivers.can.interfaces import open_bus

__all__ = ["open_bus"]
