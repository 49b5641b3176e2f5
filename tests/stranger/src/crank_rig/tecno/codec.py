"""The maker's code: two pressures of 12 bits and one flag in 32 bits.

Bits 0 to 11 and 12 to 23 are the pressures in mbar, bit 31 is the flag: in setpoints it opens the
supply, in monitors it reports a fault.
"""

from typing import Final

STEP: Final = 100.0
"""1 mbar, Pa."""
MOST: Final = 4095 * STEP
"""The greatest pressure that 12 bits hold, Pa gauge."""

Pair = tuple[float, float]


def encode_setpoints(pressures: Pair, supply: bool) -> bytes:
    """Return the setpoints' object for pressures in Pa gauge, rounded and saturated."""
    first, second = (round(min(max(pressure, 0.0), MOST) / STEP) for pressure in pressures)
    return (first | second << 12 | supply << 31).to_bytes(4, "little")


def decode_monitors(word: int) -> tuple[Pair, bool]:
    """Return the pressures, Pa gauge, and whether a fault is reported."""
    return ((word & 0xFFF) * STEP, (word >> 12 & 0xFFF) * STEP), bool(word >> 31)
