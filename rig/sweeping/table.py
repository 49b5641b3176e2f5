"""The table of a sweep: one row for each point, in the order of the points."""

import csv
import re
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from rig.config.quantities import UnitError, parse_any_quantity
from rig.hal import ConfigurationError
from rig.installation import installing
from rig.sweeping.errors import SweepStopped
from rig.sweeping.finding import PointFinding
from rig.whole_file import whole_file

if TYPE_CHECKING:
    from pyarrow import DataType

CSV, PARQUET = "sweep.csv", "sweep.parquet"
_BATCH: Final = 1024
"""SweepRows that are written at once."""

_FORMULA: Final = re.compile("'*[-+=@\t\r]")
_WHOLE: Final = re.compile(r"[-+]?[0-9]{1,18}")
_NUMBER: Final = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")

Cell = float | int | str | bool | None


class TableRow(NamedTuple):
    """A point with what became of it.

    Parameters
    ----------
    values : tuple
        Of the axes, numbers in SI.
    finding : PointFinding
        What became of it.
    """

    values: tuple[Cell, ...]
    finding: PointFinding


class Columns(NamedTuple):
    """The columns of a table.

    Parameters
    ----------
    settings : dict of str to type
        What was varied, and what its values are.
    metrics : tuple of str
        In the order in which points have them.
    """

    settings: dict[str, type]
    metrics: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The header."""
        of_metrics = (name for metric in self.metrics for name in (metric, f"{metric}.unit"))
        return ("point", *self.settings, "status", "reason", *of_metrics)

    def cells(self, row: TableRow) -> list[Cell]:
        """Return a row's cells."""
        finding = row.finding
        known = {metric["name"]: metric for metric in finding["metrics"]}
        values = [kind(v) for kind, v in zip(self.settings.values(), row.values, strict=True)]
        found: list[Cell] = [finding["point"], *values, finding["status"], finding["reason"]]
        for name in self.metrics:
            metric = known.get(name)
            found += [None, None] if metric is None else [metric["value"], metric["unit"]]
        return found


def value_of(text: str) -> Cell:
    """Return a setting's value as a table has it: a number in SI, or the text itself."""
    if _NUMBER.fullmatch(text):
        return int(text) if _WHOLE.fullmatch(text) else float(text)
    try:
        return float(parse_any_quantity(text)[0])
    except UnitError:
        return text


def guarded(cell: Cell) -> Cell:
    """Return a cell that no spreadsheet takes for a formula: an apostrophe stands before it."""
    return f"'{cell}" if isinstance(cell, str) and _FORMULA.match(cell) else cell


def unguarded(text: str) -> str:
    """Return the text of a cell as it was before `guarded`."""
    return text[1:] if text[:1] == "'" and _FORMULA.match(text[1:]) else text


def kind_of(values: Iterable[Cell]) -> type:
    """Return the type that all values of a setting can have."""
    kinds = {type(value) for value in values}
    if kinds == {int}:
        return int
    return float if kinds <= {int, float} else str


def find_columns(settings: dict[str, type], rows: Iterable[TableRow]) -> Columns:
    """Return the columns that rows need."""
    metrics: dict[str, None] = {}
    for row in rows:
        for metric in row.finding["metrics"]:
            metrics.setdefault(metric["name"])
    return Columns(settings, tuple(metrics))


def write_csv(folder: Path, columns: Columns, rows: Iterable[TableRow]) -> Path:
    """Write ``sweep.csv``, whole or not at all.

    Raises
    ------
    SweepStopped
        It cannot be written.
    """

    def write(path: Path) -> None:
        with path.open("w", encoding="utf-8", newline="") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(columns.names)
            writer.writerows(map(guarded, columns.cells(row)) for row in rows)

    return write_table(folder / CSV, write)


def write_parquet(folder: Path, columns: Columns, rows: Iterator[TableRow]) -> Path:
    """Write ``sweep.parquet``, whole or not at all.

    Raises
    ------
    ConfigurationError
        There is no pyarrow.
    SweepStopped
        It cannot be written.
    """
    try:
        import pyarrow
        from pyarrow.parquet import ParquetWriter
    except ImportError as error:
        raise ConfigurationError(
            f"there is no sweep.parquet: it takes pyarrow, {installing('pyarrow')}"
        ) from error
    types: dict[type, DataType] = {
        int: pyarrow.int64(), float: pyarrow.float64(), str: pyarrow.string()
    }  # fmt: skip
    numbers = {**columns.settings, **dict.fromkeys(columns.metrics, float)}
    schema = pyarrow.schema([(name, types[numbers.get(name, str)]) for name in columns.names])

    def write(path: Path) -> None:
        with ParquetWriter(path, schema, compression="zstd") as writer:
            while batch := [columns.cells(row) for row in islice(rows, _BATCH)]:
                data = [list(column) for column in zip(*batch, strict=True)]
                writer.write_table(pyarrow.table(data, schema=schema))

    return write_table(folder / PARQUET, write)


def write_table(path: Path, write: Callable[[Path], None]) -> Path:
    """Let somebody write a file, which is whole or not there; return its path.

    Raises
    ------
    SweepStopped
        It cannot be written.
    """
    try:
        with whole_file(path) as temporary:
            write(temporary)
    except OSError as error:
        raise SweepStopped(
            str(path), f"cannot be written: {error.strerror or error}; what is finished is kept"
        ) from error
    return path
