"""A metric over many settings: one vertical axis for each, one line for each point."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rig.report.style import INK, PAGE, VERMILION, new_figure
from rig.sweeping.curves import scale_of
from rig.sweeping.data import SweepData
from rig.sweeping.maps import short
from rig.sweeping.table import Cell

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_MOST_LINES = 2000
_MOST_LABELS = 8


def draw_parallel(data: SweepData, metric: str, varied: Sequence[str]) -> "Figure":
    """Draw each point as a line over its settings that ends at its metric, the worst on top."""
    from matplotlib.collections import LineCollection

    column = data.metrics[metric]
    factor, unit = scale_of(column)
    values = factor * column.values
    known = np.isfinite(values)
    heights = [_heights(data.settings[name]) for name in varied]
    low, high = float(np.min(values[known])), float(np.max(values[known]))
    span = high - low or 1.0
    last = np.where(known, (values - low) / span, np.nan)
    lines = np.column_stack([*(height for height, _ in heights), last])
    order = np.argsort(column.sign * np.where(known, values, np.nan), kind="stable")
    order = order[known[order]]
    order = order[np.unique(np.linspace(0, len(order) - 1, _MOST_LINES).astype(int))]
    figure = new_figure(PAGE, 80.0)
    axes = figure.subplots()
    places = np.arange(lines.shape[1])
    drawn = LineCollection(
        [np.column_stack([places, lines[number]]) for number in order], lw=0.6, alpha=0.7,
        cmap="viridis_r" if column.sign > 0.0 else "viridis",
        linestyles=["--" if data.missed[number] else "-" for number in order],
    )  # fmt: skip
    drawn.set_array(values[order])
    axes.add_collection(drawn)
    for number in np.flatnonzero(data.failed)[:_MOST_LINES]:
        axes.plot(places[:-1], lines[number, :-1], color=VERMILION, lw=0.7, ls=":")
    ticks = [*(labels for _, labels in heights), [(0.0, f"{low:.3g}"), (1.0, f"{high:.3g}")]]
    for place, labels in enumerate(ticks):
        axes.axvline(place, color=INK, lw=0.6)
        for height, text in labels:
            axes.annotate(text, (place, height), xytext=(2, 0), textcoords="offset points",
                          fontsize=6.0, va="center",
 bbox={"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.6})  # fmt: skip
    title = f"{metric.replace('_', ' ')} ({unit})" if unit else metric.replace("_", " ")
    axes.set_xticks(places, labels=[*(_folded(name) for name in varied), title])
    axes.set_yticks([])
    if data.missed.any():
        axes.set_title("dashed: a bound was missed", loc="right")
    axes.set_xlim(-0.1, places[-1] + 0.3)
    axes.set_ylim(-0.05, 1.05)
    axes.grid(visible=False)
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)
    return figure


def _heights(values: Sequence[Cell]) -> tuple["NDArray[np.float64]", list[tuple[float, str]]]:
    """Return where values lie between 0 and 1, and what is written there."""
    if all(isinstance(value, int | float) for value in values):
        numbers = np.array(values, dtype=float)
        low, high = float(numbers.min()), float(numbers.max())
        return (numbers - low) / (high - low or 1.0), [(0.0, short(low)), (1.0, short(high))]
    names = list(dict.fromkeys(values))
    share = 1.0 / max(len(names) - 1, 1)
    step = -(-len(names) // _MOST_LABELS)
    labels = [(k * share, short(name)) for k, name in list(enumerate(names))[::step]]
    return np.array([names.index(value) * share for value in values]), labels


def _folded(name: str) -> str:
    """Write a setting's dotted name in lines of its parts."""
    return name.replace(".", "\n")
