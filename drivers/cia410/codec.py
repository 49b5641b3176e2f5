"""Codec of inclinometers: counts to lean and rates."""

from typing import Final, NamedTuple

from drivers.cia410.settings import Cia410Settings

RESOLUTION: Final = 1.7453292519943295e-05
"""rad: what 0x6000 counts, a thousandth of a degree."""

Four = tuple[float, float, float, float]


class LeanCodec(NamedTuple):
    """Straight lines of roll, pitch, roll rate and pitch rate.

    Attributes
    ----------
    gains, offsets : tuple of float
        ``value = gain · counts + offset``, rad and rad/s.
    """

    gains: Four
    offsets: Four


def lean_codec(settings: Cia410Settings) -> LeanCodec:
    """Return the codec of a sensor."""
    step, rate_step = settings.step, settings.rate_step
    return LeanCodec(
        (
            settings.roll.sign * step,
            settings.pitch.sign * step,
            settings.roll_rate.sign * rate_step,
            settings.pitch_rate.sign * rate_step,
        ),
        (-settings.roll_zero, -settings.pitch_zero, 0.0, 0.0),
    )


def decode_lean(codec: LeanCodec, counts: tuple[float, ...]) -> Four:
    """Return roll and pitch, rad, and their rates, rad/s."""
    roll, pitch, roll_rate, pitch_rate = counts
    gains, offsets = codec
    return (
        gains[0] * roll + offsets[0],
        gains[1] * pitch + offsets[1],
        gains[2] * roll_rate,
        gains[3] * pitch_rate,
    )
