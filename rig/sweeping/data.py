"""A sweep's rows as columns: what figures, page and scripts take."""

import math
from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from rig.hal import ConfigurationError
from rig.run_facts import ending_word
from rig.sweeping.axis import SEED
from rig.sweeping.finding import DONE, MISSED
from rig.sweeping.table import Cell, TableRow

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(slots=True)
class MetricColumn:
    """A metric of all points; NaN where a point has none.

    Parameters
    ----------
    unit : str
        SI.
    bound : float or None
        Of the last point that has one.
    kind : str or None
        ``"max"`` or ``"min"``.
    numbers : array of float
        In the order of the points.
    """

    unit: str
    bound: float | None
    kind: str | None
    numbers: "array[float]" = field(default_factory=lambda: array("d"))

    @property
    def values(self) -> "NDArray[np.float64]":
        """The numbers; infinite ones, of what never happened, are NaN."""
        found = np.array(self.numbers)
        found[~np.isfinite(found)] = math.nan
        return found

    @property
    def never(self) -> "NDArray[np.bool_]":
        """Of which points it is infinite: what it measures never happened."""
        found: NDArray[np.bool_] = np.isinf(np.array(self.numbers))
        return found

    @property
    def sign(self) -> float:
        """1 if less is better, -1 if more is."""
        return -1.0 if self.kind == "min" else 1.0


@dataclass(slots=True)
class SweepData:
    """The points of a sweep as columns, in their order.

    Parameters
    ----------
    settings : dict of str to list
        What was varied, with its values.
    points, statuses, reasons : list of str
        The points' names, what became of them, and why.
    metrics : dict of str to MetricColumn
        By name.
    """

    settings: dict[str, list[Cell]]
    points: list[str] = field(default_factory=list)
    statuses: list[str] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    metrics: dict[str, MetricColumn] = field(default_factory=dict)

    @classmethod
    def of(cls, settings: Sequence[str], rows: Iterable[TableRow]) -> "SweepData":
        """Return rows as columns."""
        data = cls({name: [] for name in settings})
        for row in rows:
            data._add(row)
        return data

    @property
    def varied(self) -> list[str]:
        """What has more than one value, without the seed."""
        return [
            name for name, values in self.settings.items() if name != SEED and len(set(values)) > 1
        ]

    @property
    def failed(self) -> "NDArray[np.bool_]":
        """Which points did not run to their end."""
        return np.array([status not in DONE for status in self.statuses], dtype=bool)

    @property
    def missed(self) -> "NDArray[np.bool_]":
        """Which points ran to their end and missed a bound, or were flawed."""
        return np.array([status == MISSED for status in self.statuses], dtype=bool)

    def ending(self, number: int) -> str:
        """Return what became of a point, as `rig compare` says it."""
        is_flawed = not self.reasons[number].startswith("missed ")
        return ending_word(self.statuses[number], is_flawed=is_flawed)

    def metric(self, name: str | None = None) -> tuple[str, MetricColumn]:
        """Return a metric by its name, or the first one.

        Raises
        ------
        ConfigurationError
            There is none.
        """
        found = name or next(iter(self.metrics), None)
        if found is None:
            raise ConfigurationError("no point ran to its end: there is no metric")
        if found not in self.metrics:
            raise ConfigurationError(
                f"no metric is called {found!r}; there are {', '.join(self.metrics)}"
            )
        return found, self.metrics[found]

    def order(self, name: str | None = None) -> list[int]:
        """Return the numbers of the points that have a metric, the best first.

        Those that missed a bound, be it another metric's, are behind all that kept theirs.
        """
        column = self.metric(name)[1]
        values = column.sign * column.values
        numbers = np.lexsort((values, self.missed))
        return [int(number) for number in numbers if np.isfinite(values[number])]

    def _add(self, row: TableRow) -> None:
        for values, value in zip(self.settings.values(), row.values, strict=True):
            values.append(value)
        finding = row.finding
        count = len(self.points)
        self.points.append(finding["point"])
        self.statuses.append(finding["status"])
        self.reasons.append(finding["reason"])
        for metric in finding["metrics"]:
            name = metric["name"]
            if name not in self.metrics:
                self.metrics[name] = MetricColumn(metric["unit"], metric["bound"], metric["kind"])
                self.metrics[name].numbers.extend([math.nan] * count)
            self.metrics[name].numbers.append(metric["value"])
        for column in self.metrics.values():
            if len(column.numbers) == count:
                column.numbers.append(math.nan)
