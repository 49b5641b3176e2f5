"""How much of a CAN bus's time a rig needs, worst case, before anything is opened.

References
----------
CAN 2.0A data frame with 11-bit identifier and n data bytes: 44 + 8 n bits, of which 34 + 8 n
are subject to stuffing (at most one stuff bit per four after the first), and 3 bits of
interframe space: 135 bits for 8 bytes, 55 for an empty frame.
"""

from collections.abc import Iterable, Sequence
from math import inf
from typing import Protocol

from drivers.can.device_settings import CanDeviceSettings
from rig.hal import BusLoad, ConfigurationError, DriverSettings, FrameLoad


class BusTraffic(Protocol):
    """The part of a bus's settings that its load depends on."""

    @property
    def bitrate(self) -> int:
        """Of the bus, bit/s."""
        ...

    @property
    def heartbeat(self) -> float:
        """Period of all heartbeats, s; infinite if the master sends none."""
        ...

    @property
    def sync(self) -> bool:
        """Whether the master sends SYNC."""
        ...

    @property
    def max_load(self) -> float:
        """The greatest permitted load, 0 … 1."""
        ...


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
    bus: BusTraffic, devices: Iterable[tuple[str, DriverSettings]], rate: float
) -> BusLoad:
    """Compute the worst-case load of a bus.

    Parameters
    ----------
    bus : BusTraffic
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
    name: str, bus: BusTraffic, devices: Sequence[tuple[str, DriverSettings]], rate: float
) -> BusLoad:
    """Compute the load of a bus and refuse it if it is too high.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    bus, devices, rate
        See `compute_bus_load`.

    Raises
    ------
    ConfigurationError
        The load is above the bus's `max_load`; the message lists what fills it.
    """
    return compute_bus_load(bus, devices, rate).check(
        bus.max_load,
        f"bus {name}: the worst-case load at {rate:g} Hz and {bus.bitrate:g} bit/s",
        "Lower the rate, or move devices to another bus",
    )
