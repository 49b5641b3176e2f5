"""The figure of the limits that cut commands: which of them, when, and how often."""

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from rig.report.data import RunData
from rig.report.figure import TIME_LABEL, FigureKind
from rig.report.style import PAGE, VERMILION, new_figure
from rig.run_facts import read_events

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROW = 9.0
"""Height of a limit's row, mm."""


def draw_limits(run: RunData) -> "Figure | None":
    """Draw when each limit began to cut commands; None if none ever did."""
    times: dict[str, list[float]] = defaultdict(list)
    hits: dict[str, int] = {}
    for event in read_events(run.folder.path):
        t, count = event.get("t"), event.get("data", {}).get("hits")
        if event.get("kind") != "limit" or t is None or not isinstance(count, int):
            continue
        name, begins, _ = event["message"].partition(" is limited")
        if begins:
            times[name].append(t)
        hits[name.partition(" was limited")[0]] = count  # the run's last event of it: of all
    if not times:
        return None
    figure = new_figure(PAGE, 22.0 + _ROW * len(times))
    axes = figure.subplots()
    for row, began in enumerate(times.values()):
        axes.plot(
            np.interp(began, run.log.t, run.t), [row] * len(began), "|", color=VERMILION, ms=9
        )
    labels = [f"{name}: {hits[name]} cycles" for name in times]
    axes.set_yticks(range(len(times)), labels=labels)
    axes.set_ylim(len(times) - 0.5, -0.5)
    axes.set_xlim(float(run.t[0]), float(run.t[-1]))
    axes.grid(axis="y", visible=False)
    axes.set_xlabel(TIME_LABEL)
    return figure


LIMIT_FIGURES = {
    "limits": FigureKind(
        draw_limits,
        "When each limit of the profile began to cut commands, and in how many cycles it did.",
    ),
}
