"""Runs of the spherical joint side by side: how far the marker is off, and what it costs."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rig.hal.motion import Segment
from rig.report.comparison import Comparison, color_of, metric_values, write_value
from rig.report.data import RunData
from rig.report.envelope import envelope
from rig.report.figure import TIME_LABEL
from rig.report.style import INK, PAGE, SHADE, length_scale, new_figure, shade_segments

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from rig.run_facts import MetricRow

    Array = NDArray[np.float64]


_SHOWN = ("wire_rms", "wire_hold_rms", "marker_rms", "radial_rms", "fused_rms")


def draw_joints(runs: Sequence[RunData], labels: Sequence[str]) -> "Figure":
    """Draw the marker's distance from its target under each of them, beside their metrics.

    All have one scale: what differs by a factor is to look so.
    """
    bars = len(runs) * len(_errors(runs[0]))
    figure = new_figure(PAGE, max(30.0 + 22.0 * len(runs), 24.0 + 3.4 * bars))
    grid = figure.add_gridspec(len(runs), 2, width_ratios=[1.9, 1.0])
    distances = [_distance(run) for run in runs]
    extent = max(float(distance.max(initial=1e-6)) for _, distance in distances)
    factor, unit = length_scale(extent)
    top: Axes | None = None
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
    _draw_errors(figure.add_subplot(grid[:, 1]), runs)
    return figure


def _draw_errors(axes: "Axes", runs: Sequence[RunData]) -> None:
    """Draw what each run left of its errors, on a logarithmic scale, with the bounds."""
    metrics = _errors(runs[0])
    values = np.column_stack([metric_values(runs, metric["name"]) * 1e3 for metric in metrics])
    height = 0.8 / len(runs)
    for number in range(len(runs)):
        rows = np.arange(len(metrics)) + (number - 0.5 * (len(runs) - 1)) * height
        axes.barh(rows, values[number], height * 0.86, color=color_of(number))
        for row, value in zip(rows, values[number], strict=True):
            if np.isfinite(value):
                write_value(axes, f"{value:.3g}", value, row)
    for row, metric in enumerate(metrics):
        bound = metric.get("bound")
        if bound is not None and metric.get("bound_kind") == "max":
            axes.vlines(
                1e3 * bound, row - 0.46, row + 0.46,
                color=INK, lw=0.9, ls=(0, (3, 1.5)),
            )  # fmt: skip
    axes.set_xscale("log")
    axes.set_xlim(0.5 * float(np.nanmin(values)), 6.0 * float(np.nanmax(values)))
    names = [metric["name"].replace("_", " ") for metric in metrics]
    axes.set_yticks(range(len(metrics)), labels=names)
    axes.tick_params(axis="y", labelsize=6.5, length=0)
    axes.minorticks_off()
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("errors (mm), bounds dashed")


def _distance(run: RunData) -> "tuple[Array, Array]":
    source = "truth" if run.has("truth.marker_x") else "estimate"
    gap = run.track(f"{source}.marker") - run.track("reference.marker")
    return run.time, np.linalg.norm(gap, axis=1)


def _parts(run: RunData) -> list[Segment]:
    """Return the segments but the whole and parts of others."""
    return [s for s in run.segments if s.name != "all" and not s.name.endswith("last lap")]


def _errors(run: RunData) -> "list[MetricRow]":
    """Return the metrics of what was measured, not of what was known beforehand."""
    return [metric for metric in run.metrics if metric.get("measure") in _SHOWN]


JOINT_COMPARISON = Comparison(
    lambda run: run.has("reference.marker_x", "estimate.marker_x") and bool(_errors(run)),
    draw_joints,
)
