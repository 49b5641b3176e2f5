"""Physical quantities as people write them, ``"35 kPa"``, and as the program holds them, SI.

A unit is a product of powers: ``m/s^2``, ``N s/m``, ``dm^3/(s bar)``. Conversions are computed
with exact fractions and rounded once, so that ``"8.7 mm"`` is the same float as ``8.7e-3``.
Angle, bit and count are dimensions of their own: ``"10 Hz"`` is not 10 rad/s.
"""

import math
import re
from fractions import Fraction
from functools import lru_cache
from typing import Final, NamedTuple

_BASE: Final = ("m", "kg", "s", "A", "K", "rad", "bit", "count")

Dimension = tuple[int, ...]
"""Exponents of the base units `_BASE`."""


class UnitError(ValueError):
    """A text is not a unit, or not a quantity of the unit that is wanted."""


class Unit(NamedTuple):
    """A unit: SI value = scale * number + offset."""

    scale: Fraction
    dimension: Dimension
    offset: Fraction = Fraction(0)

    def times(self, other: "Unit", power: int = 1) -> "Unit":
        """Return the product with a power of another unit."""
        if self.offset or other.offset:
            raise UnitError("degC has a zero of its own and cannot be part of a product; use K")
        exponents = zip(self.dimension, other.dimension, strict=True)
        return Unit(self.scale * other.scale**power, tuple(a + power * b for a, b in exponents))


def _unit(scale: Fraction | int | float | str, **exponents: int) -> Unit:
    return Unit(Fraction(scale), tuple(exponents.get(base, 0) for base in _BASE))


ONE: Final = _unit(1)
_TURN: Final = Fraction(math.tau)

# Units that take prefixes. The gram, since the kilogram already has one.
_PREFIXABLE: Final[dict[str, Unit]] = {
    "m": _unit(1, m=1),
    "g": _unit("0.001", kg=1),
    "s": _unit(1, s=1),
    "A": _unit(1, A=1),
    "K": _unit(1, K=1),
    "rad": _unit(1, rad=1),
    "bit": _unit(1, bit=1),
    "Hz": _unit(1, s=-1),
    "N": _unit(1, kg=1, m=1, s=-2),
    "Pa": _unit(1, kg=1, m=-1, s=-2),
    "bar": _unit(100_000, kg=1, m=-1, s=-2),
    "J": _unit(1, kg=1, m=2, s=-2),
    "W": _unit(1, kg=1, m=2, s=-3),
    "V": _unit(1, kg=1, m=2, s=-3, A=-1),
    "Ohm": _unit(1, kg=1, m=2, s=-3, A=-2),
    "Ω": _unit(1, kg=1, m=2, s=-3, A=-2),
    "F": _unit(1, kg=-1, m=-2, s=4, A=2),
    "H": _unit(1, kg=1, m=2, s=-2, A=-2),
    "L": _unit("0.001", m=3),
    "l": _unit("0.001", m=3),
}
_PREFIXES: Final[dict[str, Fraction]] = {
    "n": Fraction(1, 10**9),
    "u": Fraction(1, 10**6),
    "\u00b5": Fraction(1, 10**6),  # micro sign
    "\u03bc": Fraction(1, 10**6),  # Greek mu
    "m": Fraction(1, 10**3),
    "c": Fraction(1, 100),
    "d": Fraction(1, 10),
    "h": Fraction(100),
    "k": Fraction(10**3),
    "M": Fraction(10**6),
    "G": Fraction(10**9),
}
_WHOLE: Final[dict[str, Unit]] = {
    "1": ONE,
    "%": _unit("0.01"),
    "ppm": _unit("0.000001"),
    "min": _unit(60, s=1),
    "h": _unit(3600, s=1),
    "deg": _unit(Fraction(math.pi) / 180, rad=1),
    "°": _unit(Fraction(math.pi) / 180, rad=1),
    "rev": _unit(_TURN, rad=1),
    "rpm": _unit(_TURN / 60, rad=1, s=-1),
    "count": _unit(1, count=1),
    "px": _unit(1, count=1),
    "psi": _unit("6894.757293168361", kg=1, m=-1, s=-2),
    "atm": _unit(101_325, kg=1, m=-1, s=-2),
    "NL": _unit("0.001", m=3),  # a litre of air at 1 atm and 20 °C: flows are told so
    "degC": _unit(1, K=1)._replace(offset=Fraction("273.15")),
    "°C": _unit(1, K=1)._replace(offset=Fraction("273.15")),
}

# What a person would write; those of the wanted dimension are offered in an error.
USUAL_UNITS: Final = (
    "m", "cm", "mm", "µm", "s", "ms", "µs", "min", "Hz", "kHz", "Pa", "kPa", "MPa", "bar", "psi",
    "rad", "mrad", "deg", "rad/s", "deg/s", "rpm", "rad/s^2", "deg/s^2", "m/s", "mm/s", "m/s^2",
    "mm/s^2", "m^2", "mm^2", "cm^2", "m^3", "cm^3", "dm^3", "L", "m^3/s", "NL/min", "Pa/s",
    "kPa/s", "MPa/s", "bar/s", "N", "mN", "kN", "N/m", "N/mm", "N s/m", "N s/mm", "N/Pa", "N/bar",
    "N m", "N mm", "kg", "g", "m^3/(s Pa)", "dm^3/(s bar)", "V", "mV", "A", "mA", "W", "J", "K",
    "degC", "bit/s", "kbit/s", "Mbit/s", "1", "%",
)  # fmt: skip

_QUANTITY: Final = re.compile(
    r"\s*([-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?)\s*(.*?)\s*", re.DOTALL
)
_TOKEN: Final = re.compile(r"\s*(?:([*/()·])|\^?(-?[0-9])(?![0-9])|([^\W\d_]+|[%°]C?|Ω))\s*")
_LONGEST: Final = 64
"""No quantity has more characters; it bounds the work on a hostile one."""


@lru_cache(maxsize=512)
def parse_unit(text: str) -> Unit:
    """Parse a unit.

    Parameters
    ----------
    text : str
        Such as ``"dm^3/(s bar)"``; ``""`` and ``"1"`` are the number one.

    Raises
    ------
    UnitError
        It is none, or is ambiguous: ``N/m s`` must be ``N/(m s)`` or ``N s/m``.
    """
    text = text.strip().replace("²", "^2").replace("³", "^3")
    if not text:
        return ONE
    if len(text) > _LONGEST:
        raise UnitError("the unit is too long")
    tokens = []
    at = 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise UnitError(f"{text[at:]!r} is not a unit")
        operator, power, name = match.groups()
        # A digit is the number one at the start of a factor, else an exponent after ^.
        if power is not None and "^" not in match.group():
            if power != "1":
                raise UnitError(f"{power!r} is not a unit; a power is written with ^, as in m^2")
            tokens.append(("name", "1"))
        else:
            kind = "operator" if operator else "power" if power is not None else "name"
            tokens.append((kind, operator or power or name))
        at = match.end()
    unit, rest = _product(tokens, 0)
    if rest != len(tokens):
        raise UnitError(f"{text!r} has a bracket too many")
    return unit


def _product(tokens: list[tuple[str, str]], at: int) -> tuple[Unit, int]:
    unit, divided, sign, expected, first = ONE, False, 1, True, True
    while at < len(tokens):
        kind, token = tokens[at]
        if kind == "operator" and token in "*·/":
            if expected:
                raise UnitError(f"a unit is missing before {token!r}")
            sign = -1 if token == "/" else 1
            divided, expected = divided or token == "/", True
            at += 1
            continue
        if token == ")":
            break
        if not expected and divided:
            raise UnitError("what is divided by is ambiguous; use brackets, as in N/(m s)")
        factor, at = _factor(tokens, at)
        unit = factor if first else unit.times(factor, sign)
        expected, sign, first = False, 1, False
    if expected:
        raise UnitError("a unit is missing")
    return unit, at


def _factor(tokens: list[tuple[str, str]], at: int) -> tuple[Unit, int]:
    kind, token = tokens[at]
    if token == "(":
        unit, at = _product(tokens, at + 1)
        if at >= len(tokens):
            raise UnitError("a closing bracket is missing")
    elif kind == "name":
        unit = _named(token)
    else:
        raise UnitError(f"a unit is missing before {token!r}")
    at += 1
    if at < len(tokens) and tokens[at][0] == "power":
        unit = ONE.times(unit, int(tokens[at][1]))
        at += 1
    return unit, at


def _named(name: str) -> Unit:
    if name in _WHOLE:
        return _WHOLE[name]
    if name in _PREFIXABLE:
        return _PREFIXABLE[name]
    if name[0] in _PREFIXES and name[1:] in _PREFIXABLE:
        unit = _PREFIXABLE[name[1:]]
        return unit._replace(scale=unit.scale * _PREFIXES[name[0]])
    raise UnitError(f"{name!r} is not a unit")


@lru_cache(maxsize=256)
def usual_units(unit: str) -> tuple[str, ...]:
    """Return the units that would do for a field of an SI unit, that one first."""
    dimension = parse_unit(unit).dimension
    others = [u for u in USUAL_UNITS if u != unit and parse_unit(u).dimension == dimension]
    return (unit or "1", *(other for other in others if (unit, other) != ("", "1")))


@lru_cache(maxsize=4096)  # exact arithmetic is slow, and a sweep reads a profile for each point
def parse_quantity(text: str, unit: str) -> float:
    """Convert a text to the SI number of a field.

    Parameters
    ----------
    text : str
        A number and a unit, such as ``"35 kPa"``.
    unit : str
        The field's SI unit, such as ``"Pa"``.

    Returns
    -------
    float
        In `unit`; finite.

    Raises
    ------
    UnitError
        It is no quantity or of another dimension; the message names the units that would do.
    """
    wanted = parse_unit(unit)
    would_do = ", ".join(usual_units(unit))
    try:
        number, name, given = _split(text)
    except UnitError as error:
        raise UnitError(f"{error}; wanted is a quantity in {would_do}") from None
    if not name and unit not in ("", "1"):
        raise UnitError(f"{text.strip()!r} has no unit; wanted is a quantity in {would_do}")
    if given.dimension != wanted.dimension:
        raise UnitError(
            f"{text.strip()!r} is not in {unit or '1'}; units that would do: {would_do}"
        )
    return _convert(text, number, given, wanted)


def parse_any_quantity(text: str) -> tuple[float, str]:
    """Convert a text with any unit to an SI number.

    Returns
    -------
    value : float
        SI; finite.
    unit : str
        Its SI unit: a usual one, else the product of base units.

    Raises
    ------
    UnitError
        It is no quantity.
    """
    number, _, given = _split(text)
    si = next(
        (u for u in USUAL_UNITS if parse_unit(u) == Unit(Fraction(1), given.dimension)),
        " ".join(f"{b}^{e}" for b, e in zip(_BASE, given.dimension, strict=True) if e) or "1",
    )
    return _convert(text, number, given, parse_unit(si)), si


def _split(text: str) -> tuple[str, str, Unit]:
    if len(text) > _LONGEST:
        raise UnitError(f"{text[:40]!r}… is too long for a quantity")
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise UnitError(f"{text.strip()!r} does not start with a number")
    number, name = match.groups()
    try:
        return number, name, parse_unit(name)
    except UnitError as error:
        raise UnitError(f"{text.strip()!r}: {error}") from None


def _convert(text: str, number: str, given: Unit, wanted: Unit) -> float:
    # Floats first: the exact fraction of 1e999999999 would not fit into memory.
    approximate = float(number)
    if approximate == 0.0 or not math.isfinite(approximate):
        exact = Fraction(0)
    else:
        exact = Fraction(number)
    try:
        value = float((exact * given.scale + given.offset - wanted.offset) / wanted.scale)
    except OverflowError:
        value = math.inf
    if not math.isfinite(approximate) or not math.isfinite(value):
        raise UnitError(f"{text.strip()!r} is not a finite number")
    return value


def parse_reading(text: str, unit: str) -> float:
    """Return a reading in SI, from a number or a quantity with its unit.

    Raises
    ------
    UnitError
        It is neither, or the unit measures something else.
    """
    try:
        value = float(text)
    except ValueError:
        value = parse_quantity(text.strip(), unit)
    if not math.isfinite(value):
        raise UnitError(f"{text.strip()} is no reading")
    return value
