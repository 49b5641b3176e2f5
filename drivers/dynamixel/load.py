"""How much of a serial bus's time a chain of servos needs, before anything is opened.

References
----------
A byte on the wire is 10 bits: start, 8 data, stop. ROBOTIS e-Manual, "DYNAMIXEL Protocol
2.0": a packet has 10 bytes beside its parameters.
"""

from collections.abc import Iterable, Sequence
from typing import Final

from drivers.dynamixel.codec import compute_fast_length
from drivers.dynamixel.settings import DynamixelSettings, SerialBusSettings
from rig.hal import BusLoad, FrameLoad

_BITS_PER_BYTE: Final = 10
_SYNC_OVERHEAD: Final = 14  # of a sync packet: header, id, length, instruction, range, CRC
_STATUS_OVERHEAD: Final = 11
_GOAL_SIZE: Final = 4


def compute_serial_load(
    bus: SerialBusSettings, devices: Iterable[tuple[str, DynamixelSettings]], rate: float
) -> BusLoad:
    """Compute the load of a serial bus.

    Stuffed bytes are not counted: what they add to a packet is below one in a hundred.

    Parameters
    ----------
    bus : SerialBusSettings
        Settings of the bus.
    devices : iterable of (str, DynamixelSettings)
        Name and settings of each device on it.
    rate : float
        Of the loop, Hz.
    """
    packets: list[tuple[str, int, float]] = []
    servos = 0
    block = 0
    for name, device in devices:
        count = len(device.joints)
        servos += count
        block = device.block_size
        packets.append((f"{name} setpoints", _SYNC_OVERHEAD + count * (1 + _GOAL_SIZE), 0.0))
    if servos:
        packets.append(("request", _SYNC_OVERHEAD + servos, 0.0))
        if bus.fast_sync:
            packets.append(("answer of all", compute_fast_length(block, servos), bus.turnaround))
        else:
            size = servos * (_STATUS_OVERHEAD + block)
            packets.append(("answers", size, servos * bus.turnaround))
    return BusLoad.of(
        FrameLoad(name, size, rate, (size * _BITS_PER_BYTE / bus.baudrate + delay) * rate)
        for name, size, delay in packets
    )


def check_serial_load(
    name: str, bus: SerialBusSettings, devices: Sequence[tuple[str, DynamixelSettings]], rate: float
) -> BusLoad:
    """Return what `compute_serial_load` does for the bus called `name`; refuse too much.

    Raises
    ------
    ConfigurationError
        The load is above the bus's `max_load`; the message lists what fills it.
    """
    load = compute_serial_load(bus, devices, rate)
    if load.total <= bus.max_load:
        return load
    fitting = load.fitting(rate, 0.0, bus.max_load)
    return load.check(
        bus.max_load,
        f"bus {name}: the load at {rate:g} Hz and {bus.baudrate:g} bit/s",
        f"Raise the baud rate, lower the loop's rate ({fitting}), or use a second bus",
    )
