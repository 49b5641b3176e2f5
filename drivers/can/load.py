"""How much of a CAN bus's time a rig needs, worst case, before anything is opened.

References
----------
CAN 2.0A data frame with 11-bit identifier and n data bytes: 44 + 8 n bits, of which 34 + 8 n
are subject to stuffing (at most one stuff bit per four after the first), and 3 bits of
interframe space: 135 bits for 8 bytes, 55 for an empty frame.
"""

from collections.abc import Iterable, Sequence
from math import ceil, inf

from drivers.can.bus_settings import CanInterfaceSettings
from drivers.can.device_settings import CanDeviceSettings
from rig.hal import BusLoad, ConfigurationError, DriverSettings, FrameLoad

_BITS_OF_BYTE = 10
"""One byte more in a frame, with the stuff bits of the worst case."""


def compute_frame_bits(size: int) -> int:
    """Return the longest time of a frame on the bus, bits.

    Parameters
    ----------
    size : int
        Data bytes, 0 … 8.
    """
    stuffed = 34 + 8 * size
    return 44 + 8 * size + (stuffed - 1) // 4 + 3


def compute_bus_load(
    bus: CanInterfaceSettings, devices: Iterable[tuple[str, DriverSettings]], rate: float
) -> BusLoad:
    """Compute the worst-case load of a bus.

    Parameters
    ----------
    bus : CanInterfaceSettings
        Settings of the bus.
    devices : iterable of (str, DriverSettings)
        Name and settings of each device on it.
    rate : float
        Of the loop, Hz.

    Raises
    ------
    ConfigurationError
        A driver does not say what it puts on the bus.
    """
    frames: list[tuple[str, int, float]] = []
    if bus.sync:
        frames.append(("SYNC", 0, rate))
    if bus.heartbeat < inf:
        frames.append(("heartbeat of the master", 1, 1.0 / bus.heartbeat))
    for name, device in devices:
        if not isinstance(device, CanDeviceSettings):
            raise ConfigurationError(
                f"{name}: {type(device).__name__} does not say what it puts on a CAN bus; let it "
                "inherit drivers.can.device_settings.CanDeviceSettings"
            )
        frames += [(f"{name} {frame}", size, rate) for frame, size in device.cyclic_frames()]
        timed = device.timed_frames(bus.heartbeat)
        frames += [(f"{name} {frame}", size, often) for frame, size, often in timed]
    return BusLoad.of(
        FrameLoad(name, size, often, compute_frame_bits(size) * often / bus.bitrate)
        for name, size, often in frames
    )


def check_bus_load(
    name: str, bus: CanInterfaceSettings, devices: Sequence[tuple[str, DriverSettings]], rate: float
) -> BusLoad:
    """Return what `compute_bus_load` does for the bus called `name`; refuse too much.

    Raises
    ------
    ConfigurationError
        The load is above the bus's `max_load`; the message lists what fills it.
    """
    load = compute_bus_load(bus, devices, rate)
    if load.total <= bus.max_load:
        return load
    fitting = load.fitting(rate, compute_bus_load(bus, devices, 0.0).total, bus.max_load)
    fewer = ceil((load.total - bus.max_load) * bus.bitrate / (rate * _BITS_OF_BYTE))
    return load.check(
        bus.max_load,
        f"bus {name}: the worst-case load at {rate:g} Hz and {bus.bitrate:g} bit/s",
        f"Lower the rate ({fitting}), map less (by {fewer} bytes a cycle), "
        "or move devices to another bus",
    )
