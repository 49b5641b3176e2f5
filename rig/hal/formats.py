"""Format SI numbers for people: a unit of handy size, and significant digits."""

import math
from collections.abc import Sequence
from typing import Final

_PEOPLE: Final[dict[str, tuple[tuple[float, str, float], ...]]] = {
    # SI unit: (from this absolute value on, unit, SI value of one); the last also takes the rest
    "m": ((1.0, "m", 1.0), (1e-5, "mm", 1e-3), (0.0, "µm", 1e-6)),
    "m/s": ((1.0, "m/s", 1.0), (0.0, "mm/s", 1e-3)),
    "m/s^2": ((1.0, "m/s^2", 1.0), (0.0, "mm/s^2", 1e-3)),
    "m^2": ((1e-2, "m^2", 1.0), (0.0, "mm^2", 1e-6)),
    "m^3": ((1e-2, "m^3", 1.0), (0.0, "cm^3", 1e-6)),
    "m^3/s": ((0.0, "NL/min", 1e-3 / 60),),
    "Pa": ((1e6, "MPa", 1e6), (100.0, "kPa", 1e3), (0.0, "Pa", 1.0)),
    "Pa/s": ((1e5, "MPa/s", 1e6), (100.0, "kPa/s", 1e3), (0.0, "Pa/s", 1.0)),
    "s": ((0.1, "s", 1.0), (1e-4, "ms", 1e-3), (0.0, "µs", 1e-6)),
    "Hz": ((1e3, "kHz", 1e3), (0.0, "Hz", 1.0)),
    "rad": ((0.0, "deg", math.pi / 180),),
    "bit/s": ((1e6, "Mbit/s", 1e6), (1e3, "kbit/s", 1e3), (0.0, "bit/s", 1.0)),
}
_AT_ZERO: Final = {"m": "mm", "m^3/s": "NL/min", "Pa": "kPa", "Pa/s": "kPa/s", "s": "s"}


def format_quantity(value: float, unit: str) -> str:
    """Write an SI number in the unit that a person would use.

    Parameters
    ----------
    value : float
        In `unit`.
    unit : str
        SI unit; empty or ``"1"`` for a ratio.

    Returns
    -------
    str
        With four significant digits, such as ``"0.12 mm"``.
    """
    name, scale = unit_for_people(value, unit)
    return f"{value / scale:.4g} {name}".rstrip()


def format_against(value: float | None, bound: float | None, unit: str) -> tuple[str, str]:
    """Write a number and its bound in one unit, with as many digits as tell them apart.

    Parameters
    ----------
    value : float or None
        In `unit`; None or infinite for what never happened, NaN for what is no number.
    bound : float or None
        In `unit`.
    unit : str
        SI unit; empty or ``"1"`` for a ratio.

    Returns
    -------
    tuple of str
        With four to nine significant digits, such as ``"10.8583 s"`` and ``"10.8603 s"``; the
        second is empty if there is no bound.
    """
    nothing = "NaN" if value is not None and math.isnan(value) else "never"
    if value is not None and not math.isfinite(value):
        value = None
    if bound is None:
        return (nothing if value is None else format_quantity(value, unit)), ""
    name, scale = unit_for_people(bound or value or 0.0, unit)
    if value is None:
        return nothing, f"{bound / scale:.4g} {name}".rstrip()
    for digits in range(4, 10):
        texts = [f"{number / scale:.{digits}g} {name}".rstrip() for number in (value, bound)]
        if value == bound or texts[0] != texts[1]:
            break
    return texts[0], texts[1]


def format_outside(value: float, lower: float, upper: float, unit: str) -> str:
    """Write a number that has left its range, in one unit, with digits that tell them apart.

    Parameters
    ----------
    value, lower, upper : float
        In `unit`.
    unit : str
        SI unit; empty or ``"1"`` for a ratio.

    Returns
    -------
    str
        Such as ``"-0.5545 mm, outside -0.5 … 0.5 mm"``; a bound that is none is infinite.
    """
    finite = [abs(bound) for bound in (lower, upper) if math.isfinite(bound)]
    name, scale = unit_for_people(max(finite, default=0.0) or value, unit)
    for digits in range(4, 10):
        said, low, high = (f"{x / scale:.{digits}g}" for x in (value, lower, upper))
        if said not in (low, high):
            break
    return f"{said} {name}".rstrip() + f", outside {low} … {high} {name}".rstrip()


def format_to(value: float, std: float, unit: str, others: Sequence[float] = ()) -> list[str]:
    """Write a measured number, and others like it, to two digits of its standard deviation.

    Parameters
    ----------
    value, std : float
        In `unit`; with a standard deviation of 0 there are four significant digits.
    unit : str
        SI unit; empty or ``"1"`` for a ratio.
    others : sequence of float
        In `unit`: written likewise.

    Returns
    -------
    list of str
        All in the unit of the first, such as ``["29.9940 mm", "29.9936 mm", "29.9944 mm"]``.
    """
    name, scale = unit_for_people(value, unit)
    place = math.floor(math.log10(std / scale)) - 1 if 0.0 < std < math.inf else None

    def text(number: float) -> str:
        x = number / scale
        if place is None or not math.isfinite(x):
            return f"{x:.4g}"
        if x == 0.0 or 1e-3 <= abs(x) < 1e9:
            return f"{x:.{max(-place, 0)}f}"
        return f"{x:.{max(math.floor(math.log10(abs(x))) - place, 1)}e}"

    return [f"{text(number)} {name}".rstrip() for number in (value, *others)]


def unit_for_people(value: float, unit: str) -> tuple[str, float]:
    """Return the unit that a person would use for a number, and its SI value."""
    if value == 0.0:
        name = _AT_ZERO.get(unit, "" if unit == "1" else unit)
        return name, 1.0
    for least, name, scale in _PEOPLE.get(unit, ()):
        if abs(value) >= least * (1.0 - 1e-9):
            return name, scale
    return "" if unit == "1" else unit, 1.0
