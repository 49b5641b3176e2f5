"""Runs of an antagonistic pair side by side: their errors over time, and their metrics."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rig.report.comparison import Comparison, color_of
from rig.report.data import RunData
from rig.report.envelope import envelope
from rig.report.metric_bars import draw_bars
from rig.report.style import (
    GREY,
    PAGE,
    SHADE,
    length_scale,
    new_figure,
    shade_segments,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_pair(runs: Sequence[RunData], labels: Sequence[str]) -> "Figure":
    """Draw the error of each run over time, one above the other, and their metrics."""
    figure = new_figure(PAGE, 26.0 + 24.0 * len(runs))
    has_bars = len(runs[0].metrics) > 0
    grid = figure.add_gridspec(
        len(runs), 1 + has_bars, width_ratios=[2.2, 1.0] if has_bars else None
    )
    errors = [(run.time, run.error[run.followed]) for run in runs]
    extent = max(float(np.nanmax(np.abs(error), initial=1e-9)) for _, error in errors)
    factor, unit = length_scale(extent)
    top = None
    for number, ((t, error), run, label) in enumerate(zip(errors, runs, labels, strict=True)):
        axes = figure.add_subplot(grid[number, 0], sharex=top, sharey=top)
        color = color_of(number)
        axes.axhline(0.0, color=GREY, lw=0.5)
        axes.plot(*envelope(t, error * factor), color=color, lw=0.7)
        if top is None:
            top = axes
            axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
            axes.set_ylim(-1.08 * extent * factor, 1.08 * extent * factor)
        for segment in run.segments:
            axes.axvspan(segment.start, segment.end, color=SHADE, lw=0, zorder=0)
        axes.set_title(label, loc="left", color=color, pad=2.0)
        if number < len(runs) - 1:
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel("time since the reference started (s)")
    if top is not None and runs[0].segments:
        shade_segments(top, PAGE * (0.6 if has_bars else 0.9), runs[0].segments)
    figure.supylabel(f"error ({unit})", fontsize=8.5)
    if has_bars:
        draw_bars(figure.add_subplot(grid[:, 1]), runs, labels)
    return figure


PAIR_COMPARISON = Comparison(
    lambda run: run.has("reference.position", "reading.position"), draw_pair
)
