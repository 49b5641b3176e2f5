"""A metric over two settings: a map of its median, and one of its worst case over the seeds."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rig.report.style import PAGE, VERMILION, new_figure
from rig.sweeping.curves import scale_of
from rig.sweeping.data import SweepData
from rig.sweeping.table import Cell

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_WRITTEN = 100
"""Fields of a map with so many or fewer have their numbers in them."""
_LABELS = 10


def draw_map(data: SweepData, metric: str, varied: Sequence[str]) -> "Figure":
    """Draw a metric over a grid of two settings."""
    column = data.metrics[metric]
    factor, unit = scale_of(column)
    x_name, y_name = varied
    xs, ys = (_sorted(data.settings[name]) for name in varied)
    fields: dict[tuple[int, int], list[float]] = {}
    for x, y, value in zip(
        data.settings[x_name], data.settings[y_name], factor * column.values, strict=True
    ):
        fields.setdefault((ys.index(y), xs.index(x)), []).append(float(value))
    ends = zip(data.settings[x_name], data.settings[y_name], data.missed, strict=True)
    missed = {(ys.index(y), xs.index(x)) for x, y, is_missed in ends if is_missed}
    median, worst = np.full((2, len(ys), len(xs)), np.nan)
    for place, found in fields.items():
        known = [value for value in found if np.isfinite(value)]
        if known:
            median[place] = np.median(known)
            worst[place] = max(known, key=lambda value: column.sign * value)
    panels = [("median", median)]
    if any(len(found) > 1 for found in fields.values()):
        panels.append(("worst", worst))
    figure = new_figure(PAGE, 72.0)
    low, high = np.nanmin([median, worst]), np.nanmax([median, worst])
    for axes, (title, values) in zip(
        figure.subplots(1, len(panels), squeeze=False).ravel(), panels, strict=True
    ):
        image = axes.imshow(
            values, origin="lower", aspect="auto", vmin=low, vmax=high,
            cmap="viridis_r" if column.sign > 0.0 else "viridis",
        )  # fmt: skip
        axes.grid(visible=False)
        _label(axes, xs, ys)
        axes.set_xlabel(x_name)
        axes.set_ylabel(y_name)
        axes.set_title(f"{title} of {metric.replace('_', ' ')}")
        _write(axes, values, low, high, bright_is_low=column.sign > 0.0)
        for y_place, x_place in missed:
            axes.plot(x_place, y_place, "o", ms=15.0, mfc="none", color=VERMILION, mew=0.8)
    if missed:
        figure.suptitle("ringed: a bound was missed", x=0.99, ha="right", fontsize=7.0)
    figure.colorbar(image, ax=figure.axes, label=unit, pad=0.02)
    return figure


def _write(
    axes: "Axes", values: "NDArray[np.float64]", low: float, high: float, *, bright_is_low: bool
) -> None:
    """Write the numbers where they have room, and a cross where there is none."""
    for (row, column), value in np.ndenumerate(values):
        if not np.isfinite(value):
            axes.plot(column, row, "x", ms=5.0, color=VERMILION)
        elif values.size <= _WRITTEN:
            share = (value - low) / (high - low) if high > low else 0.5
            dark = share > 0.5 if bright_is_low else share < 0.5
            axes.text(
                column, row, f"{value:.3g}", ha="center", va="center", fontsize=6.0,
                color="white" if dark else "black",
            )  # fmt: skip


def _label(axes: "Axes", xs: Sequence[Cell], ys: Sequence[Cell]) -> None:
    for values, set_ticks in ((xs, axes.set_xticks), (ys, axes.set_yticks)):
        step = -(-len(values) // _LABELS)
        set_ticks(range(0, len(values), step), labels=[short(v) for v in values[::step]])


def short(value: Cell) -> str:
    """Write a setting's value on an axis."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _sorted(values: Sequence[Cell]) -> list[Cell]:
    """Return the different values: numbers by size, others as they come."""
    found = list(dict.fromkeys(values))
    if all(isinstance(value, int | float) for value in found):
        return sorted(found, key=lambda value: float(value or 0.0))
    return found
