"""How much of a serial bus's time a chain of servos needs, before anything is opened.

References
----------
A byte on the wire is 10 bits: start, 8 data, stop. ROBOTIS e-Manual, "DYNAMIXEL Protocol
2.0": a packet has 10 bytes beside its parameters.
"""

from collections.abc import Iterable, Sequence
from typing import Final, Protocol

from drivers.dynamixel.codec import compute_fast_length
from drivers.dynamixel.settings import DynamixelSettings
from rig.hal import BusLoad, FrameLoad

_BITS_PER_BYTE: Final = 10
_SYNC_OVERHEAD: Final = 14  # of a sync packet: header, id, length, instruction, range, CRC
_STATUS_OVERHEAD: Final = 11
_GOAL_SIZE: Final = 4


class SerialTraffic(Protocol):
    """The part of a bus's settings that its load depends on."""

    @property
    def baudrate(self) -> int:
        """Of the bus, bit/s."""
        ...

    @property
    def fast_sync(self) -> bool:
        """Whether all answer in one packet."""
        ...

    @property
    def turnaround(self) -> float:
        """What an answer costs beside its bytes, s."""
        ...

    @property
    def max_load(self) -> float:
        """The greatest permitted load, 0 … 1."""
        ...


def compute_serial_load(
    bus: SerialTraffic, devices: Iterable[tuple[str, DynamixelSettings]], rate: float
) -> BusLoad:
    """Compute the load of a serial bus.

    Stuffed bytes are not counted: what they add to a packet is below one in a hundred.

    Parameters
    ----------
    bus : SerialTraffic
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
    name: str, bus: SerialTraffic, devices: Sequence[tuple[str, DynamixelSettings]], rate: float
) -> BusLoad:
    """Compute the load of a serial bus and refuse it if it is too high.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    bus, devices, rate
        See `compute_serial_load`.

    Raises
    ------
    ConfigurationError
        The load is above the bus's `max_load`; the message lists what fills it.
    """
    return compute_serial_load(bus, devices, rate).check(
        bus.max_load,
        f"bus {name}: the load at {rate:g} Hz and {bus.baudrate:g} bit/s",
        "Raise the baud rate, lower the loop's rate, or use a second bus",
    )
