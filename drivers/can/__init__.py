"""CAN interfaces behind one seam, `rig.hal.FastCanBus`."""

from drivers.can.interfaces import close_bus, open_bus

__all__ = ["close_bus", "open_bus"]
