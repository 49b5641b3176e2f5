"""The figure of a sweep, by what was varied: a curve, a map, or parallel coordinates."""

from typing import TYPE_CHECKING, Final

import numpy as np

from rig.report.style import PAGE, new_figure
from rig.sweeping.curves import NEVER, draw_curve, draw_groups
from rig.sweeping.data import MetricColumn, SweepData
from rig.sweeping.maps import draw_map
from rig.sweeping.parallel import draw_parallel
from rig.sweeping.variation_figure import draw_variations
from rig.sweeping.variations import VARIATION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PANELS: Final = 6
"""Most metrics of one figure."""


def draw_sweep(data: SweepData, metric: str | None = None) -> "Figure":
    """Draw a sweep.

    Parameters
    ----------
    data : SweepData
        Its points.
    metric : str, optional
        Which metric; default: the first one, and where there is room others beside it.

    Raises
    ------
    ConfigurationError
        There is no such metric.
    """
    name, column = data.metric(metric)
    varied = data.varied
    if VARIATION in varied:
        return draw_variations(data, name)
    if len(varied) > 1 and not np.isfinite(column.values).any():
        return _without_numbers(name, column)
    grid = len(varied) == 2 and _is_grid(data, varied)
    if len(varied) > 2 or (len(varied) == 2 and not grid):
        return draw_parallel(data, name, varied)
    if grid:
        return draw_map(data, name, varied)
    names = [name, *(other for other in data.metrics if other != name)]
    names, others = names[:_PANELS], names[_PANELS:]
    columns = 1 if len(names) == 1 else 2
    rows = -(-len(names) // columns)
    figure = new_figure(PAGE, 8.0 + 48.0 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    for axes, shown in zip(panels, names, strict=False):
        if varied and _is_numeric(data, varied[0]):
            draw_curve(axes, data, shown, varied[0])
        else:
            draw_groups(axes, data, shown, varied[0] if varied else None)
    if others:
        told = ", ".join(other.replace("_", " ") for other in others)
        figure.suptitle(f"not drawn: {told}", x=0.01, ha="left", fontsize=7.0)
    return figure


def _without_numbers(name: str, column: MetricColumn) -> "Figure":
    """Return a figure that says so of a metric that has no number at any point."""
    figure = new_figure(PAGE, 24.0)
    word = NEVER if column.never.any() else "no number"
    figure.text(0.5, 0.5, f"{name.replace('_', ' ')}: {word}", ha="center", va="center")
    return figure


def _is_numeric(data: SweepData, setting: str) -> bool:
    return all(isinstance(value, int | float) for value in data.settings[setting])


def _is_grid(data: SweepData, varied: list[str]) -> bool:
    first, second = (data.settings[name] for name in varied)
    pairs = set(zip(first, second, strict=True))
    return 2 * len(pairs) > len(set(first)) * len(set(second))
