"""What figures have in common."""

from collections.abc import Callable, Iterator
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rig.report.data import RunData
from rig.report.envelope import envelope

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TIME_LABEL = "time since the reference started (s)"


class FigureKind(NamedTuple):
    """A figure by its name.

    Parameters
    ----------
    draw : callable
        Takes a run; returns None when the log does not hold what the figure shows.
    caption : str
        For the report.
    """

    draw: "Callable[[RunData], Figure | None]"
    caption: str


def panels(figure: "Figure", rows: int, columns: int, **style: Any) -> "list[Axes]":
    """Return the axes of a grid, row by row; `style` as for ``Figure.subplots``."""
    made: list[Axes] = np.ravel(figure.subplots(rows, columns, **style)).tolist()
    return made


def draw_line(axes: "Axes", t: Any, x: Any, color: str, label: str, **style: Any) -> None:
    """Draw a signal of any length as what can be seen of it."""
    axes.plot(*envelope(t, x), color=color, label=label, solid_joinstyle="round", **style)


def finish_time_axis(axes: "Axes", t: Any, label: str) -> None:
    """Limit and label the axes of a signal over time."""
    axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
    axes.margins(y=0.08)
    axes.set_xlabel(TIME_LABEL)
    axes.set_ylabel(label)


def bounds_of(
    run: RunData, measures: set[str]
) -> Iterator[tuple[dict[str, Any], float, list[Any]]]:
    """Yield the metrics of these measures that have an upper bound, the bound, its segments."""
    for metric in run.metrics:
        if (
            metric.get("measure") in measures
            and metric.get("bound_kind") == "max"
            and metric.get("bound") is not None
        ):
            pattern = metric.get("segments", "*")
            yield (
                metric,
                metric["bound"],
                [segment for segment in run.segments if fnmatchcase(segment.name, pattern)],
            )
