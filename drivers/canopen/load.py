"""How much of a bus's time a rig needs, worst case, before anything is opened.

References
----------
CAN 2.0A data frame with 11-bit identifier and n data bytes: 44 + 8 n bits, of which 34 + 8 n
are subject to stuffing (at most one stuff bit per four after the first), and 3 bits of
interframe space: 135 bits for 8 bytes, 55 for an empty frame.
"""

from collections.abc import Iterable, Sequence
from math import inf
from typing import NamedTuple, Protocol

from rig.hal import ConfigurationError


class CyclicDevice(Protocol):
    """What the load needs to know of a device's settings.

    A device that sends other than one heartbeat besides has a method ``timed_frames``, which
    takes the period of heartbeats (s) and returns names, bytes and rates (Hz).
    """

    def cyclic_frames(self) -> tuple[tuple[str, int], ...]:
        """Return the frames of every cycle: names and bytes."""
        ...


class BusTraffic(Protocol):
    """What the load needs to know of a bus's settings."""

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


class FrameLoad(NamedTuple):
    """One frame's share.

    Attributes
    ----------
    name : str
        Device and frame.
    size : int
        Data bytes.
    rate : float
        How often it is sent, Hz.
    load : float
        Its share of the bus's time, 0 … 1.
    """

    name: str
    size: int
    rate: float
    load: float


class BusLoad(NamedTuple):
    """What fills a bus.

    Attributes
    ----------
    total : float
        Share of the bus's time, 0 … 1.
    frames : tuple of FrameLoad
        The largest first.
    """

    total: float
    frames: tuple[FrameLoad, ...]

    def table(self) -> str:
        """Return the frames as lines of text."""
        width = max((len(frame.name) for frame in self.frames), default=0)
        rows = [
            f"  {frame.name:{width}}  {frame.size} bytes at {frame.rate:>6g} Hz  "
            f"{100.0 * frame.load:5.1f} %"
            for frame in self.frames
        ]
        return "\n".join(rows)


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
    bus: BusTraffic, devices: Iterable[tuple[str, CyclicDevice]], rate: float
) -> BusLoad:
    """Compute the worst-case load of a bus.

    Parameters
    ----------
    bus : BusTraffic
        Settings of the bus.
    devices : iterable of (str, CyclicDevice)
        Name and settings of each device on it.
    rate : float
        Of the loop, Hz.
    """
    frames: list[tuple[str, int, float]] = []
    if bus.sync:
        frames.append(("SYNC", 0, rate))
    if bus.heartbeat < inf:
        frames.append(("heartbeat of the master", 1, 1.0 / bus.heartbeat))
    for name, device in devices:
        frames += [(f"{name} {frame}", size, rate) for frame, size in device.cyclic_frames()]
        timed = getattr(device, "timed_frames", _one_heartbeat)(bus.heartbeat)
        frames += [(f"{name} {frame}", size, often) for frame, size, often in timed]
    loads = [
        FrameLoad(name, size, often, compute_frame_bits(size) * often / bus.bitrate)
        for name, size, often in frames
    ]
    loads.sort(key=lambda frame: -frame.load)
    return BusLoad(sum(frame.load for frame in loads), tuple(loads))


def _one_heartbeat(period: float) -> tuple[tuple[str, int, float], ...]:
    return (("heartbeat", 1, 1.0 / period),)


def check_bus_load(
    name: str, bus: BusTraffic, devices: Sequence[tuple[str, CyclicDevice]], rate: float
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
    load = compute_bus_load(bus, devices, rate)
    if load.total > bus.max_load:
        raise ConfigurationError(
            f"bus {name}: the worst-case load at {rate:g} Hz and {bus.bitrate:g} bit/s is "
            f"{100.0 * load.total:.1f} %, at most {100.0 * bus.max_load:g} % is allowed. "
            f"Lower the rate, or move devices to another bus:\n{load.table()}"
        )
    return load
