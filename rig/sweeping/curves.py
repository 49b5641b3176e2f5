"""A metric over one setting: its median, and how far it goes over the seeds."""

from typing import TYPE_CHECKING

import numpy as np

from rig.hal.formats import unit_for_people
from rig.report.style import BLUE, GREY, INK, VERMILION
from rig.sweeping.data import MetricColumn, SweepData

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

NEVER = "never"
"""Is said of what never came, as in tables."""


def draw_curve(axes: "Axes", data: SweepData, metric: str, setting: str) -> None:
    """Draw a metric over a setting that is a number."""
    column = data.metrics[metric]
    factor, label = scale_of(column)
    x = np.array(data.settings[setting], dtype=float)
    y = factor * column.values
    places = np.unique(x)
    spread = np.array([_spread(y[x == place]) for place in places])
    worst = spread[:, 0] if column.sign < 0.0 else spread[:, 2]
    if len(y) > len(places):
        axes.fill_between(places, spread[:, 0], spread[:, 2], color=BLUE, alpha=0.15, lw=0)
        axes.plot(x, y, ".", ms=2.0, color=GREY, zorder=1)
        axes.plot(places, worst, color=VERMILION, lw=0.7, ls=(0, (4, 2)), label="worst")
    axes.plot(places, spread[:, 1], "o-", ms=2.5, color=BLUE, label="median")
    _mark_missed(axes, x[data.missed], y[data.missed])
    _mark_failed(axes, x[data.failed])
    _mark_never(axes, column, x)
    if _is_logarithmic(places):
        axes.set_xscale("log")
    axes.set_xlabel(setting)
    _finish(axes, column, metric, label, factor)


def draw_groups(axes: "Axes", data: SweepData, metric: str, setting: str | None) -> None:
    """Draw a metric for each value of a setting that is no number, or of all seeds."""
    column = data.metrics[metric]
    factor, label = scale_of(column)
    y = factor * column.values
    groups = data.settings[setting] if setting is not None else [""] * len(y)
    names = list(dict.fromkeys(groups))
    place_of = {name: place for place, name in enumerate(names)}
    x = np.array([place_of[group] for group in groups], dtype=float)
    for place in range(len(names)):
        low, middle, high = _spread(y[x == place])
        axes.plot([place, place], [low, high], color=BLUE, lw=4.0, alpha=0.25)
        axes.plot(place, middle, "o", ms=4.0, color=BLUE, label="median" if place == 0 else None)
    aside = 0.12 * np.sin(2.4 * np.arange(len(y)))  # beside each other where many are alike
    axes.plot(x + aside, y, ".", ms=2.0, color=GREY, zorder=1)
    _mark_missed(axes, (x + aside)[data.missed], y[data.missed])
    _mark_failed(axes, x[data.failed])
    _mark_never(axes, column, x)
    axes.set_xticks(range(len(names)), labels=[str(name) for name in names])
    axes.set_xlim(-0.6, len(names) - 0.4)
    axes.set_xlabel(setting or f"{len(y)} points")
    _finish(axes, column, metric, label, factor)


def scale_of(column: MetricColumn) -> tuple[float, str]:
    """Return factor and unit in which a metric's greatest number is told in a table."""
    values = np.abs(column.values)
    greatest = float(np.nanmax(values)) if np.isfinite(values).any() else 0.0
    name, scale = unit_for_people(greatest or column.bound or 0.0, column.unit)
    return 1.0 / scale, name


def _spread(values: "NDArray[np.float64]") -> tuple[float, float, float]:
    """Return least, median and greatest value."""
    known = values[np.isfinite(values)]
    if not len(known):
        return np.nan, np.nan, np.nan
    return float(known.min()), float(np.median(known)), float(known.max())


def _mark_missed(axes: "Axes", x: "NDArray[np.float64]", y: "NDArray[np.float64]") -> None:
    """Ring the points that missed a bound, be it another metric's."""
    if np.isfinite(y).any():
        axes.plot(x, y, "o", ms=5.0, mfc="none", color=VERMILION, mew=0.7, ls="none",
                  label="bound missed")  # fmt: skip


def _mark_failed(axes: "Axes", x: "NDArray[np.float64]") -> None:
    """Mark where points failed, at the top of the axes."""
    if len(x):
        axes.plot(
            x, np.full(len(x), 0.97), "x", ms=4.0, mew=0.9, color=VERMILION, label="failed",
            transform=axes.get_xaxis_transform(), clip_on=False,
        )  # fmt: skip


def _mark_never(axes: "Axes", column: MetricColumn, x: "NDArray[np.float64]") -> None:
    """Mark where it never came: at the top of the axes, and in a word where it never did."""
    if not column.never.any():
        return
    if not np.isfinite(column.values).any():
        axes.text(0.5, 0.5, NEVER, ha="center", va="center", transform=axes.transAxes)
        axes.set_yticks([])
        margin = 0.05 * (np.ptp(x) or 1.0)
        axes.set_xlim(x.min() - margin, x.max() + margin)
        for line in axes.get_lines():  # what nobody sees is in no legend
            if not np.isfinite(line.get_ydata()).any():
                line.set_label("_")
        return
    x = x[column.never]
    axes.plot(
        x, np.full(len(x), 0.97), "^", ms=3.0, mew=0.7, mfc="none", color=INK, label=NEVER,
        transform=axes.get_xaxis_transform(), clip_on=False,
    )  # fmt: skip


def _is_logarithmic(places: "NDArray[np.float64]") -> bool:
    """Return whether values look as if they were spaced by a factor."""
    if len(places) < 3 or places[0] <= 0.0 or places[-1] / places[0] < 20.0:
        return False
    return bool(np.median(places) < 0.25 * (places[0] + places[-1]))


def _finish(axes: "Axes", column: MetricColumn, metric: str, unit: str, factor: float) -> None:
    if column.bound is not None:
        bound, (low, high) = factor * column.bound, axes.get_ylim()
        if low - (high - low) < bound < high + (high - low):
            axes.axhline(bound, color=INK, lw=0.8, ls=(0, (3, 1.5)), label="bound")
        else:  # it would flatten the curve
            axes.plot([], [], ls="none", label=f"bound {bound:.3g} {unit}".rstrip())
    axes.set_ylabel(f"{metric.replace('_', ' ')} ({unit})" if unit else metric.replace("_", " "))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, columnspacing=1.0)
