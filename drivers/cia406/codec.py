"""Codec of linear encoders: counts to extension and speed, alarm bits to words."""

from collections.abc import Callable
from typing import Final, NamedTuple

from drivers.cia406.settings import Cia406Settings

_ALARMS: Final = {0: "position error"}  # the others differ from maker to maker


class LinearCodec(NamedTuple):
    """Counts to SI, one straight line each.

    Attributes
    ----------
    gain, offset : float
        ``extension = gain · counts + offset``, m.
    speed_gain : float
        ``velocity = speed_gain · counts``, m/s.
    """

    gain: float
    offset: float
    speed_gain: float


def linear_codec(settings: Cia406Settings, step: float, speed_step: float) -> LinearCodec:
    """Return the codec for measuring steps (m and m/s per count)."""
    factor = -settings.scale if settings.reversed else settings.scale
    return LinearCodec(factor * step, settings.offset, factor * speed_step)


def position_decoder(codec: LinearCodec) -> Callable[[float], float]:
    """Return ``decode(counts)``, the extension, m, with everything that it needs at hand."""
    gain, offset = codec.gain, codec.offset
    return lambda counts: gain * counts + offset


def decode_velocity(codec: LinearCodec, counts: float) -> float:
    """Return the velocity, m/s."""
    return codec.speed_gain * counts


def describe_alarms(alarms: int) -> str:
    """Return the bits of 0x6503 in words."""
    return ", ".join(_ALARMS.get(bit, f"bit {bit}") for bit in range(16) if alarms >> bit & 1)
