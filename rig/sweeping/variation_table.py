"""One table of a sweep with variations: law by variation, the worst last, faults by name."""

import csv
import json
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

from rig.hal.formats import format_quantity
from rig.sweeping.data import SweepData
from rig.sweeping.finding import DONE
from rig.sweeping.maps import short
from rig.sweeping.table import guarded, write_table
from rig.sweeping.variations import VARIATION, WORST

CSV, JSON = "variations.csv", "variations.json"

_DEVICE: Final = re.compile(r"[\w.-]+(?: \(node 0x[0-9A-F]+\))?: (?=\D)")
_FIGURES: Final = re.compile(r"[\d,;:\[(]")
_LEFT_OVER: Final = frozenset(("a", "at", "by", "for", "in", "is", "of", "than", "the", "to"))


class Cell(NamedTuple):
    """The outcome of one variation under one law.

    Parameters
    ----------
    value : float
        The worst of those that came to their end, SI; NaN: none did; infinite: what it times never
        happened.
    stopped : tuple of str
        Why each of the others did not.
    missed : int
        How many of those that came to their end missed a bound.
    """

    value: float
    stopped: tuple[str, ...]
    missed: int = 0

    def text(self, unit: str) -> str:
        """Return it for a person: a figure, or the name of what stopped it."""
        if self.stopped:
            others = f" ({len(self.stopped)} runs)" if len(self.stopped) > 1 else ""
            return f"{fault_name(self.stopped[0])}{others}"
        if math.isinf(self.value):
            return "never, bound missed" if self.missed else "never"
        if math.isnan(self.value):
            return "-"
        told = format_quantity(self.value, unit or "1")
        return f"{told}, bound missed" if self.missed else told


class VariationTable(NamedTuple):
    """A metric of every variation under every law.

    Parameters
    ----------
    metric, unit : str
        Its name, and its SI unit.
    laws : tuple of str
        The columns: what is varied besides, of which seeds are no part.
    rows : dict of str to tuple of Cell
        Of each variation, in the order of `laws`.
    worst : tuple of Cell
        The worst of each law.
    """

    metric: str
    unit: str
    laws: tuple[str, ...]
    rows: dict[str, tuple[Cell, ...]]
    worst: tuple[Cell, ...]

    def texts(self) -> list[tuple[str, ...]]:
        """Return its rows for a person, the worst last."""
        rows = [(name, *(cell.text(self.unit) for cell in cells)) for name, cells in
                self.rows.items()]  # fmt: skip
        worst = []
        for cell in self.worst:
            value = cell._replace(stopped=()).text(self.unit)
            worst.append(f"{len(cell.stopped)} stopped, {value}" if cell.stopped else value)
        return [*rows, (WORST, *worst)]

    def faults(self) -> dict[str, str]:
        """Return what stopped any of them: a name, and one sentence that has it."""
        return {
            fault_name(reason): reason for cell in reversed(self.worst) for reason in cell.stopped
        }


def fault_name(reason: str) -> str:
    """Return the words of a fault without its device and figures: they name it."""
    words = _FIGURES.split(_DEVICE.sub("", reason, count=1), maxsplit=1)[0].split()
    while words and words[-1] in _LEFT_OVER:
        words.pop()
    return " ".join(words) or reason


def table_of(data: SweepData, metric: str) -> VariationTable:
    """Return the table of a metric; `data` has a column `VARIATION`."""
    column = data.metrics[metric]
    others = [name for name in data.varied if name != VARIATION]
    laws = [" ".join(short(data.settings[name][k]) for name in others)
            for k in range(len(data.points))]  # fmt: skip
    places: dict[tuple[str, str], list[int]] = {}
    for k, (variation, law) in enumerate(zip(data.settings[VARIATION], laws, strict=True)):
        places.setdefault((str(variation), law), []).append(k)

    def cell(numbers: Sequence[int]) -> Cell:
        known = [v for v in column.values[list(numbers)].tolist() if math.isfinite(v)]
        nothing = math.inf if column.never[list(numbers)].any() else math.nan
        value = max(known, key=lambda v: column.sign * v) if known else nothing
        stopped = (data.reasons[k] or data.statuses[k] for k in numbers
                   if data.statuses[k] not in DONE)  # fmt: skip
        return Cell(value, tuple(stopped), int(data.missed[list(numbers)].sum()))

    names = tuple(dict.fromkeys(laws))
    rows = {
        str(variation): tuple(cell(places.get((str(variation), law), ())) for law in names)
        for variation in dict.fromkeys(data.settings[VARIATION])
    }
    all_of = [[k for k, other in enumerate(laws) if other == law] for law in names]
    return VariationTable(metric, column.unit, names, rows, tuple(map(cell, all_of)))


def write_variations(folder: Path, data: SweepData) -> None:
    """Write the tables of all metrics: for people in CSV, with every reason in JSON.

    Raises
    ------
    SweepStopped
        They cannot be written.
    """
    tables = [table_of(data, metric) for metric in data.metrics]
    laws = tables[0].laws if tables else ()

    def write(path: Path) -> None:
        with path.open("w", encoding="utf-8", newline="") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(["metric", VARIATION, *(law or "value" for law in laws)])
            writer.writerows(
                [guarded(text) for text in (table.metric, *row)]
                for table in tables for row in table.texts()
            )  # fmt: skip

    write_table(folder / CSV, write)
    plain = json.dumps([_plain(table) for table in tables], indent=1) + "\n"
    write_table(folder / JSON, lambda path: _put(path, plain))


def _put(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _plain(table: VariationTable) -> dict[str, object]:
    rows = {**table.rows, WORST: table.worst}
    return {
        "metric": table.metric,
        "unit": table.unit,
        "laws": table.laws,
        "rows": {
            name: [
                {
                    "value": cell.value if math.isfinite(cell.value) else None,
                    "stopped": cell.stopped,
                    "missed": cell.missed,
                }
                for cell in cells
            ]
            for name, cells in rows.items()
        },
    }
