"""The figure of a sweep, by what was varied: a curve, a map, or parallel coordinates."""

from typing import TYPE_CHECKING, Final

from rig.report.style import PAGE, new_figure
from rig.sweeping.curves import draw_curve, draw_groups
from rig.sweeping.data import SweepData
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
    name, _ = data.metric(metric)
    varied = data.varied
    if VARIATION in varied:
        return draw_variations(data, name)
    grid = len(varied) == 2 and _is_grid(data, varied)
    if len(varied) > 2 or (len(varied) == 2 and not grid):
        return draw_parallel(data, name, varied)
    if grid:
        return draw_map(data, name, varied)
    names = [name, *(other for other in data.metrics if other != name)][:_PANELS]
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
    return figure


def _is_numeric(data: SweepData, setting: str) -> bool:
    return all(isinstance(value, int | float) for value in data.settings[setting])


def _is_grid(data: SweepData, varied: list[str]) -> bool:
    first, second = (data.settings[name] for name in varied)
    pairs = set(zip(first, second, strict=True))
    return 2 * len(pairs) > len(set(first)) * len(set(second))
