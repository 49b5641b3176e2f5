"""One axis of a sweep: a setting and the values that it takes, as they are written."""

import re
from fractions import Fraction
from typing import Final, Literal, NamedTuple

from rig.config.quantities import UnitError, parse_any_quantity
from rig.config.setting import Setting
from rig.hal import ConfigurationError
from rig.sweeping.written import Written, on_command_line

MAX_VALUES: Final = 100_000
"""Most values of one axis."""

SEED: Final = "simulation.seed"
"""The setting that ``--seeds`` varies."""

Kind = Literal["uniform", "sobol", "normal"]

_LARGEST: Final = 1e150
"""Of the numbers of a range: so that what is computed with two of them is a number."""
_NUMBER: Final = (
    r"[-+]?(?:[0-9]{1,40}(?:\.[0-9]{1,40})?|\.[0-9]{1,40})(?:[eE][-+]?[0-9]{1,3})?"
    r"(?![0-9]|[eE][-+]?[0-9])"  # the rest of a longer number is no unit
)
_RANGE: Final = re.compile(
    rf"(?:(?P<kind>log|uniform|sobol):)?\s*(?P<low>{_NUMBER})\s*(?P<unit>[^.:,]*?)\s*\.\.\s*"
    rf"(?P<high>{_NUMBER})\s*(?P<unit_high>[^:,]*?)\s*"
    r":\s*(?P<count>[0-9]{1,9})\s*"
)
_NORMAL: Final = re.compile(
    rf"normal:\s*(?P<low>{_NUMBER})\s*(?:\+-|±)\s*(?P<high>{_NUMBER})\s*(?P<unit>[^:,]*?)\s*"
    r":\s*(?P<count>[0-9]{1,9})\s*"
)
_MEANT_AS_RANGE: Final = re.compile(r"(log|uniform|sobol|normal):.*|.*[0-9]\s*\.\.\s*[-+.0-9].*")
_FORMS: Final = (
    "1..5:9 (nine values), log:1..100:5, uniform:0..1:50, sobol:0..1:64, normal:1+-0.1:50, "
    "or values with commas"
)


class Axis(NamedTuple):
    """A setting and the values that it takes in turn.

    Parameters
    ----------
    setting : str
        Its dotted name, as for ``--set``.
    texts : tuple of str
        The values, as for ``--set``.
    written : callable
        How it was.
    """

    setting: str
    texts: tuple[str, ...]
    written: Written = on_command_line

    def options(self, text: str) -> tuple[Setting, ...]:
        """Return one of its values as options for ``--set``: as one."""
        return (Setting(f"{self.setting}={text}", self.written("vary", self.setting, text)),)


class DrawnAxis(NamedTuple):
    """A setting whose values are drawn, together with those of other drawn axes.

    Parameters
    ----------
    setting : str
        Its dotted name.
    kind : str
        ``"uniform"`` and ``"sobol"`` lie between `low` and `high`; ``"normal"`` has the mean
        `low` and the standard deviation `high`.
    low, high : float
        In `unit`.
    unit : str
        Written after each number; may be empty.
    draws : int
        How many values.
    written : callable
        How it was.
    """

    setting: str
    kind: Kind
    low: float
    high: float
    unit: str
    draws: int
    written: Written = on_command_line


def parse_axis(text: str) -> Axis | DrawnAxis:
    """Parse ``a.b=VALUES``.

    Raises
    ------
    ConfigurationError
        It is not of that form.
    """
    setting, equals, values = text.partition("=")
    setting, values = setting.strip(), values.strip()
    if not equals or not setting or not values:
        raise ConfigurationError(
            f"--vary {text}: expected a setting and its values, as in a.b=1..5:9"
        )
    return make_axis(setting, values)


def make_axis(setting: str, values: str, written: Written = on_command_line) -> Axis | DrawnAxis:
    """Return the axis of a setting from its values as they are written.

    Raises
    ------
    ConfigurationError
        They are of no form that there is, or too many.
    """
    said = written("vary", setting, values)
    found = _RANGE.fullmatch(values) or _NORMAL.fullmatch(values)
    if found is None:
        if _MEANT_AS_RANGE.fullmatch(values):
            raise ConfigurationError(f"{said}: no such range; there is {_FORMS}")
        listed = tuple(dict.fromkeys(_split(said, values)))
        bare = [value for value in listed if _unit_of(value) == "1"]
        united = [value for value in listed if _unit_of(value) not in (None, "1")]
        if bare and united:  # 1,2,3 mm: nobody means metres by the first two
            raise ConfigurationError(
                f"{said}: {bare[0]!r} has no unit, and {united[0]!r} has one; "
                "in a list each value has its own"
            )
        return Axis(setting, listed, written)
    low, high, count = float(found["low"]), float(found["high"]), int(found["count"])
    if max(abs(low), abs(high)) > _LARGEST:
        raise ConfigurationError(f"{said}: the numbers of a range lie within ±{_LARGEST:g}")
    unit = found["unit"] or found.groupdict().get("unit_high") or ""
    if found.groupdict().get("unit_high") and found["unit"] not in ("", found["unit_high"]):
        raise ConfigurationError(f"{said}: both ends of a range have the same unit")
    if not 1 <= count <= MAX_VALUES:
        raise ConfigurationError(f"{said}: {count} values; an axis has 1 to {MAX_VALUES:,}")
    if values.startswith("normal"):
        return DrawnAxis(setting, "normal", low, high, unit, count, written)
    kind = found["kind"]
    if kind == "uniform":
        return DrawnAxis(setting, "uniform", low, high, unit, count, written)
    if kind == "sobol":
        return DrawnAxis(setting, "sobol", low, high, unit, count, written)
    if kind == "log":
        if not min(low, high) * _LARGEST >= 1.0:
            raise ConfigurationError(
                f"{said}: both ends of a logarithmic range are greater than 0, {1 / _LARGEST:g} at "
                "least"
            )
        numbers = [low * (high / low) ** _share(i, count) for i in range(count)]
    else:
        numbers = _evenly(Fraction(found["low"]), Fraction(found["high"]), count)
    return Axis(setting, tuple(dict.fromkeys(with_unit(x, unit) for x in numbers)), written)


def _unit_of(value: str) -> str | None:
    """Return the SI unit of a quantity, "1" of a number, None of what is neither."""
    try:
        return parse_any_quantity(value)[1]
    except UnitError:
        return None


def parse_seeds(text: str) -> Axis:
    """Parse ``FIRST:END``, the end left out, or seeds with commas.

    Raises
    ------
    ConfigurationError
        It is not of that form.
    """
    found = re.fullmatch(r"\s*([0-9]{1,18})\s*:\s*([0-9]{1,18})\s*", text)
    if found:
        first, end = int(found[1]), int(found[2])
        if not 1 <= end - first <= MAX_VALUES:
            raise ConfigurationError(
                f"--seeds {text}: {max(end - first, 0)} seeds; an axis has 1 to {MAX_VALUES:,}"
            )
        return Axis(SEED, tuple(map(str, range(first, end))))
    if not re.fullmatch(r"\s*[0-9]{1,18}(\s*,\s*[0-9]{1,18})*\s*", text):
        raise ConfigurationError(f"--seeds {text}: expected 0:20 (seeds 0 to 19) or 3,5,8")
    return Axis(SEED, tuple(dict.fromkeys(str(int(seed)) for seed in text.split(","))))


def with_unit(number: float, unit: str) -> str:
    """Write a number with its unit; twelve digits, so that it is the same on every machine."""
    return f"{number:.12g} {unit}".rstrip()


def _share(i: int, count: int) -> float:
    return i / (count - 1) if count > 1 else 0.0


def _evenly(low: Fraction, high: Fraction, count: int) -> list[float]:
    if count == 1:
        return [float(low)]
    return [float(low + (high - low) * i / (count - 1)) for i in range(count)]


def _split(said: str, values: str) -> list[str]:
    """Split a list at the commas that stand in no bracket and no quotes."""
    parts, depth, quote = [""], 0, ""
    for char in values:
        if quote:
            quote = "" if char == quote else quote
        elif char in "\"'":
            quote = char
        else:
            depth += (char in "[{") - (char in "]}")
        if char == "," and depth == 0 and not quote:
            parts.append("")
        else:
            parts[-1] += char
    texts = [part.strip() for part in parts]
    if not all(texts):
        raise ConfigurationError(f"{said}: a value between commas is missing")
    if len(texts) > MAX_VALUES:
        raise ConfigurationError(f"{said}: {len(texts)} values; an axis has 1 to {MAX_VALUES:,}")
    return texts
