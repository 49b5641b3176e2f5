"""The kinds of figure, and what they share."""

from collections.abc import Callable, Iterable, Iterator
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rig.report.data import RunData
from rig.report.envelope import envelope

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from numpy.typing import NDArray

    from rig.hal.motion import Segment
    from rig.run_facts import MetricRow

TIME_LABEL = "time since the reference started (s)"


class FigureKind(NamedTuple):
    """A figure by its name.

    Parameters
    ----------
    draw : callable
        Takes a run; returns None when the log does not hold what the figure shows.
    caption : str
        For the report.
    table : callable, optional
        Takes the run; returns what the figure is drawn from, as the pieces of a CSV, one after
        the other. Default: its lines.
    """

    draw: "Callable[[RunData], Figure | None]"
    caption: str
    table: "Callable[[RunData], Iterable[str]] | None" = None


def panels(figure: "Figure", rows: int, columns: int, **style: Any) -> "list[Axes]":
    """Return the axes of a grid, row by row; `style` as for ``Figure.subplots``."""
    made: list[Axes] = np.ravel(figure.subplots(rows, columns, **style)).tolist()
    return made


def halves(figure: "Figure", ratio: float) -> "tuple[SubFigure, SubFigure]":
    """Return the left part of a figure, so many times as wide as the right one, and that one."""
    grid = figure.add_gridspec(
        1, 2, width_ratios=[ratio, 1.0], left=0.0, right=1.0, bottom=0.0, top=1.0
    )
    return figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])


def draw_line(
    axes: "Axes",
    t: "NDArray[np.float64]",
    x: "NDArray[np.float64]",
    color: str,
    label: str,
    *,
    lw: float | None = None,
    ls: str | tuple[int, tuple[int, int]] = "-",
) -> None:
    """Draw a signal of any length as what can be seen of it."""
    axes.plot(*envelope(t, x), color=color, label=label, solid_joinstyle="round", lw=lw, ls=ls)


def finish_time_axis(
    axes: "Axes", t: "NDArray[np.float64]", label: str, below: str = TIME_LABEL
) -> None:
    """Limit and label the axes of a signal over time."""
    axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
    axes.margins(y=0.08)
    axes.set_xlabel(below)
    axes.set_ylabel(label)


def bounds_of(
    run: RunData, measures: set[str]
) -> "Iterator[tuple[MetricRow, float, list[Segment]]]":
    """Yield the metrics of these measures that have an upper bound, the bound, its segments."""
    for metric in run.metrics:
        bound, pattern = metric.get("bound"), metric.get("segments", "*")
        is_upper = metric.get("measure") in measures and metric.get("bound_kind") == "max"
        if is_upper and bound is not None:
            yield metric, bound, [s for s in run.segments if fnmatchcase(s.name, pattern)]
