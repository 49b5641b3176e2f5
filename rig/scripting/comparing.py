"""`rig.compare`: recorded runs side by side."""

import html
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rig.hal import ConfigurationError
from rig.report.compare import compare_metrics, comparison_figure
from rig.report.comparison import ComparisonRow
from rig.scripting.recorded import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Compared:
    """Runs side by side: their metrics, and the figure that suits them.

    Parameters
    ----------
    runs : mapping of str to Run
        By their labels.
    """

    def __init__(self, runs: Mapping[str, Run]) -> None:
        strangers = [run for run in runs.values() if not isinstance(run, Run)]
        if strangers:
            raise ConfigurationError(f"{strangers[0]!r} is no run: rig.load(path) makes one")
        if len(runs) < 2:
            raise ConfigurationError("a comparison takes two runs at least")
        self.runs = dict(runs)

    @property
    def rows(self) -> list[ComparisonRow]:
        """Each metric, with its value in every run: SI, None where a run has it not."""
        return compare_metrics([run.path for run in self.runs.values()], list(self.runs))

    def figure(self) -> "Figure":
        """Draw the runs over each other."""
        return comparison_figure([run.path for run in self.runs.values()], list(self.runs))

    def _cells(self) -> list[list[str]]:
        return [
            [row["name"], *(_cell(value, row["unit"]) for value in row["values"])]
            for row in self.rows
        ]

    def __repr__(self) -> str:
        cells = [["", *self.runs], *self._cells()]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        return "\n".join(
            "  ".join(text.rjust(width) for text, width in zip(line, widths, strict=True)).rstrip()
            for line in cells
        )

    def _repr_html_(self) -> str:
        rows = [["", *self.runs], *self._cells()]
        return f"<table>{''.join(_row(row) for row in rows)}</table>"


def compare(runs: Mapping[str, Run] | Sequence[Run]) -> Compared:
    """Compare recorded runs.

    Parameters
    ----------
    runs : mapping of str to Run, or sequence of Run
        By labels; without, they are called by their folders.

    Raises
    ------
    ConfigurationError
        There are fewer than two.
    """
    if isinstance(runs, Mapping):
        return Compared(runs)
    return Compared({run.path.name: run for run in runs})


def _cell(value: object, unit: str) -> str:
    from rig.hal.formats import format_quantity

    if isinstance(value, float | int):
        return format_quantity(float(value), unit or "1")
    return "-" if value is None else str(value)


def _row(cells: Sequence[str]) -> str:
    return f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in cells)}</tr>"
