"""Runs of the spherical joint side by side: how far the marker is off, and what it costs."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rig.report.comparisons.base import Comparison, color_of
from rig.report.comparisons.metrics import draw_bars
from rig.report.data import RunData
from rig.report.envelope import envelope
from rig.report.figures.base import TIME_LABEL
from rig.report.style import PAGE, SHADE, length_scale, new_figure, shade_segments

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def draw_joints(runs: Sequence[RunData], labels: Sequence[str]) -> "Figure":
    """Draw the marker's distance from its target under each of them, beside their metrics.

    All have one scale: what differs by a factor is to look so.
    """
    figure = new_figure(PAGE, max(30.0 + 22.0 * len(runs), 20.0 + 7.0 * _lengths(runs[0])))
    grid = figure.add_gridspec(len(runs), 2, width_ratios=[1.9, 1.0])
    distances = [_distance(run) for run in runs]
    extent = max(float(distance.max(initial=1e-6)) for _, distance in distances)
    factor, unit = length_scale(extent)
    top: Any = None
    for number, ((t, distance), run, label) in enumerate(zip(distances, runs, labels, strict=True)):
        axes = figure.add_subplot(grid[number, 0], sharex=top, sharey=top)
        color = color_of(number)
        axes.plot(*envelope(t, distance * factor), color=color, lw=0.7)
        if top is None:
            top = axes
            axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
            axes.set_ylim(0.0, 1.08 * extent * factor)
        for segment in _parts(run):
            axes.axvspan(segment.start, segment.end, color=SHADE, lw=0, zorder=0)
        axes.set_title(label, loc="left", color=color, pad=2.0)
        if number < len(runs) - 1:
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel(TIME_LABEL)
    if top is not None and _parts(runs[0]):
        shade_segments(top, PAGE * 0.55, _parts(runs[0]))
    figure.supylabel(f"marker off its target ({unit})", fontsize=8.5)
    draw_bars(figure.add_subplot(grid[:, 1]), runs, labels)
    return figure


def _distance(run: RunData) -> "tuple[Array, Array]":
    source = "truth" if run.has("truth.marker_x") else "estimate"
    gap = [
        run.log.column(f"{source}.marker_{axis}") - run.log.column(f"reference.marker_{axis}")
        for axis in "xyz"
    ]
    return run.t[run.followed], np.linalg.norm(gap, axis=0)[run.followed]


def _parts(run: RunData) -> list[Any]:
    """Return the segments but the whole and parts of others."""
    return [s for s in run.segments if s.name != "all" and not s.name.endswith("last lap")]


def _lengths(run: RunData) -> int:
    return sum(metric["unit"] == "m" for metric in run.metrics)


JOINT_COMPARISON = Comparison(
    lambda run: run.has("reference.marker_x", "estimate.marker_x"), draw_joints
)
