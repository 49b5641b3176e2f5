"""What judges a rig: the truth of its plant against the hazards of its profile, nothing else."""

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rig.hal.formats import format_against
from rig.hal.hazards import Hazard

Samples = NDArray[np.float64]


class Violation(NamedTuple):
    """A hazard that became true.

    Parameters
    ----------
    hazard, column : str
        Which, and of what.
    t : float
        When first, s.
    worst, bound : float
        The farthest value, and the bound that it broke.
    unit : str
        Of both.
    """

    hazard: str
    column: str
    t: float
    worst: float
    bound: float
    unit: str

    def __str__(self) -> str:
        of = "" if self.hazard == self.column else f" of {self.column}"
        worst, bound = format_against(self.worst, self.bound, self.unit)
        return (
            f"{self.hazard}{of}: {worst} beyond {bound} (the limit with its margin), first at "
            f"{self.t:.3f} s"
        )


def judge(
    hazards: Sequence[Hazard],
    columns: Sequence[str],
    times: Samples,
    rows: Samples,
    *,
    safe_from: float,
    forgiven: Collection[str] = (),
) -> list[Violation]:
    """Return every hazard that was true at some time, the worst column of each.

    Parameters
    ----------
    hazards : sequence of Hazard
        Of the profile.
    columns : sequence of str
        Of the plant's truth.
    times : ndarray, shape (n,)
        s, ascending.
    rows : ndarray, shape (n, len(columns))
        What was true then.
    safe_from : float
        From when on the rig was said to be safe, or had to be, s.
    forgiven : collection of str
        Names of hazards that this fault brings with it.
    """
    for hazard in hazards:
        if hazard.is_last and hazard.name in forgiven:
            first = min(_first(hazard, columns, times, rows), default=math.inf)
            times, rows = times[times < first], rows[times < first]
    found: dict[str, Violation] = {}
    for hazard in hazards:
        if hazard.name in forgiven:
            continue
        for column in hazard.columns:
            violation = _worst(hazard, column, times, rows[:, columns.index(column)], safe_from)
            if violation is not None and _excess(violation) > _excess(found.get(hazard.name)):
                found[hazard.name] = violation
    return list(found.values())


def judged_values(hazard: Hazard, times: Samples, truth: Samples) -> Samples:
    """Return what of a column's truth is held against a hazard's bounds, shape (n,)."""
    values = np.array([hazard.of(float(value)) for value in truth])
    return np.gradient(values, times) if hazard.is_rate else values


def _first(hazard: Hazard, columns: Sequence[str], times: Samples, rows: Samples) -> list[float]:
    """Return when each column that broke a hazard did so first, s."""
    found = [
        _worst(hazard, column, times, rows[:, columns.index(column)], -math.inf)
        for column in hazard.columns
    ]
    return [violation.t for violation in found if violation is not None]


def _worst(
    hazard: Hazard, column: str, times: Samples, truth: Samples, safe_from: float
) -> Violation | None:
    values = judged_values(hazard, times, truth)
    if hazard.only_safe:
        kept = times >= safe_from
        times, values = times[kept], values[kept]
    excess = np.maximum(values - hazard.high, hazard.low - values)
    excess[np.isnan(values)] = np.inf  # a plant that has left what numbers can say
    broken = np.flatnonzero(excess > 0.0)
    if not broken.size:
        return None
    worst = int(np.argmax(excess))
    bound = hazard.high if values[worst] > hazard.high else hazard.low
    first = float(times[broken[0]])
    return Violation(hazard.name, column, first, float(values[worst]), bound, hazard.unit)


def _excess(violation: Violation | None) -> float:
    if violation is None:
        return -1.0
    excess = abs(violation.worst - violation.bound)
    return math.inf if math.isnan(excess) else excess
