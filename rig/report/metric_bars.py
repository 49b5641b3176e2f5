"""The metrics of any runs side by side, as bars."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rig.report.comparison import Comparison, color_of, metric_values, write_value
from rig.report.data import RunData
from rig.report.style import INK, PAGE, length_scale, new_figure
from rig.run_facts import never_came

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_bars(axes: "Axes", runs: Sequence[RunData], labels: Sequence[str]) -> None:
    """Draw each metric that is a length as one group of bars; without any, those of one unit."""
    its_unit = next((m["unit"] for m in runs[0].metrics if m["unit"] == "m"), None)
    if its_unit is None and runs[0].metrics:
        its_unit = runs[0].metrics[0]["unit"]
    metrics = {m["name"]: m for m in runs[0].metrics if m["unit"] == its_unit}
    if not metrics:
        axes.set_axis_off()
        return
    height = 0.8 / len(runs)
    values = np.column_stack([metric_values(runs, name) for name in metrics])
    finite = values[np.isfinite(values)]
    greatest = float(finite.max()) if len(finite) else 0.0
    factor, unit = length_scale(greatest) if its_unit == "m" else (1.0, its_unit or "1")
    for number, label in enumerate(labels):
        rows = np.arange(len(metrics)) + (number - 0.5 * (len(runs) - 1)) * height
        axes.barh(rows, values[number] * factor, height * 0.86, color=color_of(number), label=label)
        for row, value in zip(rows, values[number] * factor, strict=True):
            known = bool(np.isfinite(value))
            write_value(axes, f"{value:.3g}" if known else "never", value if known else 0.0, row)
    for row, metric in enumerate(metrics.values()):
        bound = metric.get("bound")
        if bound is not None and metric.get("bound_kind") == "max":
            axes.vlines(
                bound * factor, row - 0.46, row + 0.46,
                color=INK, lw=0.9, ls=(0, (3, 1.5)),
            )  # fmt: skip
    axes.set_yticks(range(len(metrics)), labels=[name.replace("_", "\n") for name in metrics])
    axes.set_ylim(len(metrics) - 0.5, -0.5)
    axes.grid(axis="y", visible=False)
    axes.margins(x=0.16)
    axes.set_xlim(left=0.0)
    axes.set_xlabel(f"metric ({unit}), bound dashed")


def draw_metrics(runs: Sequence[RunData], labels: Sequence[str]) -> "Figure":
    """Draw one panel per metric, one bar per run."""
    metrics = {m["name"]: m["unit"] for m in runs[0].metrics}
    figure = new_figure(PAGE, 14.0 + 5.0 * len(runs) * max(1, -(-len(metrics) // 3)))
    if not metrics:
        return figure
    panels = figure.subplots(-(-len(metrics) // 3), 3, squeeze=False).ravel()
    for axes in panels[len(metrics) :]:
        axes.set_axis_off()
    for number, (axes, (name, unit)) in enumerate(zip(panels, metrics.items(), strict=False)):
        values = metric_values(runs, name)
        axes.barh(range(len(runs)), values, 0.7, color=[color_of(k) for k in range(len(runs))])
        for row, value in enumerate(values):
            if np.isfinite(value):
                write_value(axes, f"{value:.3g}", max(value, 0.0), row)
            elif any(one["name"] == name and never_came(one) for one in runs[row].metrics):
                write_value(axes, "never", 0.0, row)
        axes.set_yticks(range(len(runs)), labels=labels if number % 3 == 0 else [""] * len(runs))
        axes.invert_yaxis()
        axes.grid(axis="y", visible=False)
        axes.margins(x=0.25)
        axes.set_title(f"{name.replace('_', ' ')} ({unit})" if unit else name.replace("_", " "))
    return figure


METRICS_COMPARISON = Comparison(lambda run: True, draw_metrics)
