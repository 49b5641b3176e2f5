"""When a sweep may end: a metric is as good as was asked for; and what may be spent on it."""

import re
from typing import Final, NamedTuple

from rig.config.quantities import UnitError, parse_any_quantity
from rig.config.settings import NUMBER
from rig.hal import ConfigurationError
from rig.sweeping.finding import PointFinding

_RULE: Final = re.compile(r"\s*([\w.+-]+)\s*(<=|>=|<|>)\s*(.+?)\s*")
_POINTS: Final = re.compile(r"\s*([0-9]+)\s*points?\s*")


class StopRule(NamedTuple):
    """A metric and the bound that it has to keep.

    Parameters
    ----------
    metric : str
        Its name.
    sign : str
        ``<``, ``<=``, ``>`` or ``>=``.
    bound : float
        In `unit`.
    unit : str
        SI; empty for a plain number, which holds for any unit.
    """

    metric: str
    sign: str
    bound: float
    unit: str

    def reached(self, finding: PointFinding) -> bool:
        """Return whether a point keeps the bound.

        Raises
        ------
        ConfigurationError
            The metric has another unit.
        """
        for metric in finding["metrics"]:
            if metric["name"] == self.metric:
                if self.unit and self.unit != metric["unit"]:
                    raise ConfigurationError(
                        f"stop when: the bound of {self.metric} is in {self.unit}, the metric in "
                        f"{metric['unit'] or 'no unit'}"
                    )
                value = metric["value"]
                less, equal = value < self.bound, value == self.bound
                greater = value > self.bound
                return (less if "<" in self.sign else greater) or (equal and "=" in self.sign)
        return False


def parse_stop_rule(text: str) -> StopRule:
    """Parse ``marker_rms < 0.2 mm``.

    Raises
    ------
    ConfigurationError
        It is not of that form.
    """
    found = _RULE.fullmatch(text)
    try:
        if found is None:
            raise UnitError("expected a metric, a sign and a bound, as in marker_rms < 0.2 mm")
        bound, unit = parse_any_quantity(found[3])
        is_bare = re.fullmatch(NUMBER, found[3]) is not None
        return StopRule(found[1], found[2], float(bound), "" if is_bare else unit)
    except UnitError as error:
        raise ConfigurationError(f"stop when {text!r}: {error}") from error


def parse_budget(text: str) -> tuple[float | None, float | None]:
    """Parse ``30 min`` or ``500 points``; return seconds and points, one of them None.

    Raises
    ------
    ConfigurationError
        It is neither.
    """
    found = _POINTS.fullmatch(text)
    if found:
        return None, float(found[1])
    try:
        return parse_duration(text), None
    except ConfigurationError as error:
        raise ConfigurationError(f"budget {error}; or as in 500 points") from error


def parse_duration(text: str) -> float:
    """Parse a time, s.

    Raises
    ------
    ConfigurationError
        It is none.
    """
    try:
        seconds, unit = parse_any_quantity(text)
    except UnitError as error:
        raise ConfigurationError(f"{text!r}: {error}") from error
    if unit != "s" or not seconds >= 0.0:
        raise ConfigurationError(f"{text!r}: expected a time, as in 30 min")
    return float(seconds)
