"""The table of a comparison, as people read it: one unit to a row, and what became of each run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rig.hal.formats import unit_for_people

if TYPE_CHECKING:
    from pathlib import Path

    from rig.report.comparison import ComparisonRow


def table_lines(
    labels: Sequence[str],
    rows: Sequence[ComparisonRow],
    endings: Mapping[str, str],
    margins: Mapping[str, str],
) -> list[str]:
    """Return the lines of a table with a column for each run.

    Parameters
    ----------
    labels : sequence of str
        What each run is called.
    rows : sequence of ComparisonRow
        A number for each run.
    endings : mapping of str to str
        How a run ended, or that it was refused. They are shown if one of them is not ``ok``.
    margins : mapping of str to str
        What a linear model says of a run's loop; empty: nothing of any.

    Returns
    -------
    list of str
        The first one has the labels.
    """
    cells = [["", *labels], *([row["name"], *_cells(row)] for row in rows)]
    if any(ending != "ok" for ending in endings.values()):
        cells.append(["run", *(endings.get(label, "-") for label in labels)])
    if margins:
        cells.append(["linear loop", *(margins.get(label, "unknown") for label in labels)])
    widths = [max(len(line[column]) for line in cells) for column in range(len(cells[0]))]
    lines = []
    for line in cells:
        texts = [line[0].ljust(widths[0])]
        texts += [text.rjust(width) for text, width in zip(line[1:], widths[1:], strict=True)]
        lines.append("  ".join(texts).rstrip())
    return lines


def saying_never(rows: Sequence[ComparisonRow], runs: Sequence[Path]) -> list[ComparisonRow]:
    """Return rows that say so of what a run has measured and what never came.

    Parameters
    ----------
    rows : sequence of ComparisonRow
        The first numbers of each are those of the runs, in their order.
    runs : sequence of Path
        Run folders.
    """
    from rig.run_facts import never_came, read_metrics

    never = [{one["name"] for one in read_metrics(run) if never_came(one)} for run in runs]
    told: list[ComparisonRow] = []
    for row in rows:
        values = list(row["values"])
        for k, names in enumerate(never):
            if values[k] is None and row["name"] in names:
                values[k] = "never"
        told.append({**row, "values": values})
    return told


def _cells(row: ComparisonRow) -> list[str]:
    """Return a row's values in the unit that suits the greatest: eyes compare digits, not units."""
    unit = row["unit"] or "1"
    numbers = [abs(value) for value in row["values"] if isinstance(value, int | float)]
    name, scale = unit_for_people(max(numbers, default=0.0), unit)
    return [
        "-"
        if value is None
        else value
        if isinstance(value, str)
        else f"{value / scale:.4g} {name}".rstrip()
        for value in row["values"]
    ]
