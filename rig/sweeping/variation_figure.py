"""The figure of a sweep with variations: a row for each, a mark for each law, and the worst."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from rig.report.style import INK, PAGE, PALETTE, SHADE, new_figure
from rig.sweeping.curves import scale_of
from rig.sweeping.data import SweepData
from rig.sweeping.variation_table import VariationTable, table_of
from rig.sweeping.variations import WORST

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANELS: Final = 3
"""Most metrics of one figure."""
_MARKS: Final = ("o", "s", "^", "D", "v", "P")
_STOPPED: Final = 1.04
"""Where those stand that were stopped, over the width of the axes."""


def draw_variations(data: SweepData, metric: str) -> "Figure":
    """Draw a metric, and others of its unit where there is room, for each variation and law."""
    unit = data.metrics[metric].unit
    alike = [name for name, column in data.metrics.items() if column.unit == unit]
    names = [metric, *(name for name in alike if name != metric)][:_PANELS]
    tables = [table_of(data, name) for name in names]
    rows = [*tables[0].rows, WORST]
    figure = new_figure(PAGE, 22.0 + 4.6 * len(rows))
    panels: Sequence[Axes] = figure.subplots(1, len(names), sharey=True, squeeze=False)[0]
    for axes, table in zip(panels, tables, strict=True):
        factor, shown = scale_of(data.metrics[table.metric])
        _draw(axes, table, factor)
        what = table.metric.replace("_", " ")
        axes.set_xlabel(f"{what} ({shown})" if shown else what)
    panels[0].set_yticks(range(len(rows)), labels=rows)
    panels[0].set_ylim(len(rows) - 0.4, -0.6)
    handles, labels = panels[0].get_legend_handles_labels()
    if any(labels):
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _draw(axes: "Axes", table: VariationTable, factor: float) -> None:
    rows = [*table.rows.values(), table.worst]
    beside = np.linspace(-0.27, 0.27, len(table.laws)) if len(table.laws) > 1 else [0.0]
    for k in range(0, len(rows), 2):
        axes.axhspan(k - 0.5, k + 0.5, color=SHADE, lw=0.0, zorder=0)
    axes.axhline(len(rows) - 1.5, color=INK, lw=0.6)
    known = [factor * cell.value for row in rows for cell in row if np.isfinite(cell.value)]
    for number, law in enumerate(table.laws):
        color, mark = PALETTE[number % len(PALETTE)], _MARKS[number % len(_MARKS)]
        places = np.arange(len(rows)) + beside[number]
        worst = np.array([row[number].value for row in rows])
        values = factor * np.where(np.isfinite(worst), worst, np.nan)
        missed = np.array([bool(row[number].missed) for row in rows])
        axes.plot(values, places, mark, ms=3.2, color=color, label=law or None, ls="none")
        if missed.any():
            axes.plot(values[missed], places[missed], mark, ms=3.2, color=color, mfc="white",
                      ls="none")  # fmt: skip
        stopped = places[[bool(row[number].stopped) for row in rows]]
        if len(stopped):  # a line without points has no place, and no layout can be found for it
            axes.plot(np.full(len(stopped), _STOPPED), stopped, "x", ms=3.6, mew=0.9, color=color,
                      transform=axes.get_yaxis_transform(), clip_on=False)  # fmt: skip
    if known and min(known) > 0.0 and max(known) > 5.0 * min(known):
        axes.set_xscale("log")
    said = ["hollow: bound missed"] if any(cell.missed for cell in table.worst) else []
    said += ["x: stopped"] if any(cell.stopped for cell in table.worst) else []
    axes.set_title("; ".join(said), loc="right")
