"""Codec of analogue channels: converter counts ↔ signal on the wire ↔ pressure, or opening."""

from collections.abc import Callable
from math import ceil, floor, inf
from typing import NamedTuple

from drivers.canopen.mapping import RANGES
from drivers.cia401.channel_settings import MonitorSignal, OpeningSignal, SetpointSignal


class SetpointCodec(NamedTuple):
    """Pressure, or a valve's opening, to counts, one straight line.

    Attributes
    ----------
    zero, span, raw_zero, raw_span : float
        ``counts = (value - zero) · raw_span / span + raw_zero``; in
        this order the middle of a range is exactly in the middle, so that rounding half to
        even means what it says.
    low, high : float
        What the channel can give, Pa gauge, or openings.
    raw_low, raw_high : float
        Counts that its object can hold and its signal covers.
    is_integer : bool
        Whether counts are whole numbers.
    """

    zero: float
    span: float
    raw_zero: float
    raw_span: float
    low: float
    high: float
    raw_low: float
    raw_high: float
    is_integer: bool


class MonitorCodec(NamedTuple):
    """Counts to pressure, one straight line, and the signal that tells a broken wire.

    Attributes
    ----------
    gain, offset : float
        ``pressure = gain · counts + offset``.
    signal_gain, signal_offset : float
        ``signal = signal_gain · counts + signal_offset``, V or A.
    broken_below, broken_above : float
        Signals outside tell a broken or shorted wire, V or A.
    """

    gain: float
    offset: float
    signal_gain: float
    signal_offset: float
    broken_below: float
    broken_above: float

    @property
    def intact_counts(self) -> tuple[float, float]:
        """Counts between which the wire is well; nothing is told if `broken_below` is 0."""
        if self.broken_below == 0.0:
            return -inf, inf
        ends = (
            (signal - self.signal_offset) / self.signal_gain
            for signal in (self.broken_below, self.broken_above)
        )
        low, high = sorted(ends)
        return low, high


def setpoint_codec(signal: SetpointSignal | OpeningSignal) -> SetpointCodec:
    """Return the codec of an analogue output."""
    zero, raw_zero = signal.ends[0], signal.raw[0]
    low, high = sorted(signal.ends)
    raw_low, raw_high = sorted(signal.raw)
    bounds = RANGES.get(signal.type)
    if bounds is not None:  # whole numbers only, or struct refuses them
        raw_low, raw_high = ceil(raw_low), floor(raw_high)
    return SetpointCodec(
        zero,
        signal.ends[1] - zero,
        raw_zero,
        signal.raw[1] - raw_zero,
        low,
        high,
        raw_low,
        raw_high,
        bounds is not None,
    )


def monitor_codec(signal: MonitorSignal) -> MonitorCodec:
    """Return the codec of an analogue input.

    A current above 1.05 times the upper end (21 mA, NAMUR NE 43) tells a shorted sensor.
    """
    below = signal.broken_below
    above = 1.05 * max(signal.signal) if below > 0.0 and signal.current is not None else inf
    return MonitorCodec(
        *_line(signal.raw, signal.pressure), *_line(signal.raw, signal.signal), below, above
    )


def setpoint_encoder(codec: SetpointCodec) -> Callable[[float], int | float]:
    """Return ``encode(value)`` of a channel, with everything that it needs at hand.

    It returns the counts for a pressure (Pa gauge) or an opening: clamped, rounded half to even,
    saturated. It raises ValueError if that is not a number, which a limit should have stopped
    long before.
    """
    zero, span, raw_zero, raw_span, low, high, raw_low, raw_high, whole = codec

    def encode(value: float) -> int | float:
        if value - value != 0.0:  # infinite or not a number, in a third of isfinite()'s time
            raise ValueError(f"the setpoint is {value}, which is no number")
        # Comparisons, because min() and max() take five times as long.
        value = low if value < low else high if value > high else value
        raw = (value - zero) * raw_span / span + raw_zero
        if whole:
            raw = round(raw)
        return raw_low if raw < raw_low else raw_high if raw > raw_high else raw

    return encode


def encode_pressure(codec: SetpointCodec, pressure: float) -> int | float:
    """Return the counts for one pressure (Pa gauge); see `setpoint_encoder`."""
    return setpoint_encoder(codec)(pressure)


def pressure_decoder(codec: MonitorCodec) -> Callable[[float], float]:
    """Return ``decode(counts)`` of a channel, Pa gauge, with everything that it needs at hand."""
    gain, offset = codec.gain, codec.offset
    return lambda raw: gain * raw + offset


def decode_signal(codec: MonitorCodec, raw: float) -> float:
    """Return the signal on the wire for counts, V or A."""
    return codec.signal_gain * raw + codec.signal_offset


def _line(xs: tuple[float, float], ys: tuple[float, float]) -> tuple[float, float]:
    gain = (ys[1] - ys[0]) / (xs[1] - xs[0])
    return gain, ys[0] - gain * xs[0]
