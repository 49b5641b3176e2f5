"""What a sweep came to: its rows in the order of its points, and the files that hold them."""

import csv
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

from rig.hal import ConfigurationError, RigError
from rig.sweeping.best_points import as_columns, best_points
from rig.sweeping.coordinator import Coordinator
from rig.sweeping.data import SweepData
from rig.sweeping.design import Design
from rig.sweeping.finding import PointFinding
from rig.sweeping.journal import Journal
from rig.sweeping.table import (
    CSV,
    Cell,
    Columns,
    TableRow,
    find_columns,
    kind_of,
    unguarded,
    value_of,
    write_csv,
    write_parquet,
)
from rig.sweeping.variation_table import write_variations
from rig.sweeping.variations import VARIATION

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class SweepEnd(StrEnum):
    """The end of a sweep."""

    DONE = "done"
    INTERRUPTED = "interrupted"
    BUDGET = "budget"


@dataclass(frozen=True, slots=True)
class SweepRows:
    """The finished points of a sweep, in their order; read from the journal each time.

    Parameters
    ----------
    design : Design
        All points.
    coordinator : Coordinator
        Knows their names.
    journal : Journal
        Holds what became of them.
    """

    design: Design
    coordinator: Coordinator
    journal: Journal

    def __iter__(self) -> Iterator[TableRow]:
        names, end = self.coordinator.names, self.coordinator.end
        count = len(names) // 16 if end is None else end + 1
        for number in range(count):
            finding = self._finding(names[16 * number : 16 * number + 16].hex())
            if finding is not None:
                values = tuple(map(value_of, self.design.texts(number)))
                yield TableRow(values, finding)

    def _finding(self, name: str) -> PointFinding | None:
        if name in self.journal:
            return self.journal[name]
        return self.coordinator.lost.get(name)

    def columns(self) -> Columns:
        """Return the columns that they need."""
        kinds = {axis.setting: kind_of(map(value_of, axis.texts)) for axis in self.design.axes}
        return find_columns(kinds, self)


@dataclass(frozen=True, slots=True, repr=False)
class Sweep:
    """A sweep that has ended; printed, it is a table of its best points.

    Parameters
    ----------
    folder : Path
        Holds ``sweep.csv``, figures, the page and the run folders that were kept.
    end : SweepEnd
        How it ended.
    total : int
        How many points it has; the table has those that are finished.
    columns : Columns
        Of the table.
    data : SweepData
        The table as columns.
    """

    folder: Path
    end: SweepEnd
    total: int
    columns: Columns
    data: SweepData

    @property
    def table(self) -> list[dict[str, Cell]]:
        """The rows, SI; what a point has not is None."""
        numbers = {**self.columns.settings, **dict.fromkeys(self.columns.metrics, float)}
        with (self.folder / CSV).open(encoding="utf-8", newline="") as stream:
            return [
                {
                    name: numbers.get(name, str)(unguarded(text)) if text else None
                    for name, text in row.items()
                }
                for row in csv.DictReader(stream)
            ]

    def best(self, metric: str | None = None) -> dict[str, Cell]:
        """Return the row that is best in a metric; default: the first one.

        Raises
        ------
        ConfigurationError
            No point has it.
        """
        order = self.data.order(metric)
        if not order:
            raise ConfigurationError("no point ran to its end: none is the best")
        return self.table[order[0]]

    @property
    def complete(self) -> bool:
        """Whether all of its points are finished."""
        return len(self.data.points) == self.total

    def __repr__(self) -> str:
        head = f"{self.folder.name}: {self.end}, {len(self.data.points)} of {self.total} points"
        if not self.data.metrics:
            return head
        name, _ = self.data.metric(None)
        return f"{head}; best in {name}:\n{as_columns(*best_points(self.data, None))}"

    def figure(self, metric: str | None = None) -> "Figure":
        """Draw a metric over what was varied; default: the first one, and others beside it."""
        from rig.sweeping.figure import draw_sweep

        return draw_sweep(self.data, metric)


class SweepInterrupted(RigError, KeyboardInterrupt):
    """Somebody interrupted a sweep. What is finished is kept; the same call goes on from there.

    Attributes
    ----------
    sweep : Sweep
        Of the points that are finished.
    """

    def __init__(self, sweep: Sweep) -> None:
        self.sweep = sweep
        done = len(sweep.data.points)
        super().__init__(
            f"interrupted after {done} of {sweep.total} points, which are in {sweep.folder}; the "
            "same call goes on from there"
        )


def write_sweep(folder: Path, rows: SweepRows, end: SweepEnd, say: Callable[[str], None]) -> Sweep:
    """Write the tables of a sweep, and return it.

    Raises
    ------
    SweepStopped
        They cannot be written.
    """
    columns = rows.columns()
    is_first = not (folder / CSV).exists()
    write_csv(folder, columns, rows)
    try:
        write_parquet(folder, columns, iter(rows))
    except ConfigurationError as error:
        if is_first:  # not again whenever the sweep goes on
            say(str(error))
    data = SweepData.of(tuple(columns.settings), rows)
    if VARIATION in data.settings:
        write_variations(folder, data)
    return Sweep(folder, end, rows.design.count, columns, data)
