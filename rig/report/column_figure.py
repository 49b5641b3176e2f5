"""The figure of any column of a log: what a device of one's own measures, without code for it."""

import re
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Final

import numpy as np

from rig.hal.formats import unit_for_people
from rig.report.data import RunData
from rig.report.figure import TIME_LABEL, FigureKind, draw_line, panels
from rig.report.style import BLUE, PAGE, new_figure, shade_segments

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS: Final = re.compile(r"\w+(\.[\w*?-]+)+")
"""A column has a group; whatever else a name may be, it becomes that of a file."""
_MOST: Final = 8
"""Columns that have a panel."""


def is_column(name: str) -> bool:
    """Return whether a figure's name is that of a column of the log, or a pattern of some."""
    return _COLUMNS.fullmatch(name) is not None


def file_of(name: str) -> str:
    """Return the file's name, without suffix, of a figure of columns."""
    return name.replace("*", "all").replace("?", "x")


def column_figure(name: str) -> FigureKind:
    """Return the figure of the columns that a name or a pattern (``device.oil_*``) means."""

    def draw(run: RunData) -> "Figure | None":
        return draw_columns(run, name)

    return FigureKind(draw, f"{name} over time, as it was logged.")


def draw_columns(run: RunData, pattern: str) -> "Figure | None":
    """Draw columns of the log over time, one above the other; None if there are none.

    Parameters
    ----------
    run : RunData
        The run.
    pattern : str
        The name of a column, or a pattern of several as shells have them.
    """
    columns = [column for column in run.log.columns if fnmatchcase(column.name, pattern)][:_MOST]
    if not columns:
        return None
    figure = new_figure(PAGE, 26.0 + 26.0 * len(columns))
    rows = panels(figure, len(columns), 1, sharex=True)
    t = run.t
    for axes, column in zip(rows, columns, strict=True):
        values = run.log.column(column.name)
        largest = float(np.nanmax(np.abs(values), initial=0.0))
        unit, scale = unit_for_people(largest, column.unit or "1")
        draw_line(axes, t, values / scale, BLUE, column.name, lw=0.8)
        axes.set_title(f"{column.name}: {column.description}", loc="left")
        quantity = column.name.rpartition(".")[2].replace("_", " ")
        axes.set_ylabel(f"{quantity}\n({unit or '1'})")
        axes.margins(y=0.08)
        axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
    shade_segments(rows[0], PAGE, [s for s in run.segments if s.name != "all"])
    rows[-1].set_xlabel(TIME_LABEL)
    figure.align_ylabels()
    return figure
