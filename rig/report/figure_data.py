"""What a figure shows, as a table: every line of every panel, for whoever draws it again."""

import csv
import io
from collections.abc import Iterator
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D


def table_of(figure: "Figure") -> str:
    """Return what a figure's lines show, as CSV.

    Parameters
    ----------
    figure : Figure
        Drawn.

    Returns
    -------
    str
        Two columns for each line (three where a panel has depth), in the order in which they were
        drawn. The header says panel, line and axis; long signals have the least and the greatest
        of each stretch, as they are drawn. No header begins as a spreadsheet's formula does.
    """
    columns = [column for panel, axes in enumerate(figure.axes, 1) for column in _of(axes, panel)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([header for header, _ in columns])
    writer.writerows(zip_longest(*(values for _, values in columns), fillvalue=""))
    return text.getvalue()


def _of(axes: "Axes", panel: int) -> Iterator[tuple[str, list[str]]]:
    title = axes.get_title() or axes.get_title(loc="left")
    place = f"panel {panel}" + (f" ({title})" if title else "")
    names = [_along(axes), axes.get_ylabel(), *_depth(axes)]
    for number, line in enumerate(axes.lines, 1):
        label = str(line.get_label())
        name = f"line {number}" if label.startswith("_") else label
        for axis, values, said in zip(names, _values(line), _said(axes, line), strict=False):
            if not said:
                continue
            header = ", ".join(filter(None, (place, name, axis)))
            yield " ".join(header.split()), [f"{value:.9g}" for value in values]


def _along(axes: "Axes") -> str:
    """Return the name of the horizontal axis; of panels above each other the lowest says it."""
    siblings = axes.get_shared_x_axes().get_siblings(axes)
    return next(filter(None, (each.get_xlabel() for each in [axes, *siblings])), "")


def _said(axes: "Axes", line: "Line2D") -> tuple[bool, bool, bool]:
    """Return along which axes a line says something: one across the panel only along the other."""
    if not line.get_transform().contains_branch(axes.transData):
        x, y = line.get_transform().contains_branch_seperately(axes.transData)
        return x, y, True
    return True, True, True


def _depth(axes: "Axes") -> list[str]:
    """Return the name of the third axis, if there is one."""
    label = getattr(axes, "get_zlabel", None)
    return [] if label is None else [label()]


def _values(line: "Line2D") -> list["np.ndarray[tuple[int], np.dtype[np.float64]]"]:
    deep = getattr(line, "get_data_3d", None)
    data = line.get_data() if deep is None else deep()
    return [np.atleast_1d(np.asarray(values, dtype=float)) for values in data]
