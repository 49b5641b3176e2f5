"""Several runs of one experiment side by side: one figure and one table."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rig.hal import ConfigurationError
from rig.report.data import RunData, load_run
from rig.report.envelope import envelope
from rig.report.style import (
    GREY,
    INK,
    PAGE,
    PALETTE,
    length_scale,
    new_figure,
    paper_style,
    save,
    shade_segments,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compare_metrics(paths: Sequence[str | Path], labels: Sequence[str]) -> list[dict[str, Any]]:
    """Collect the metrics of several runs.

    Parameters
    ----------
    paths : sequence of Path
        Run folders.
    labels : sequence of str
        What to call each run, e.g. its controller.

    Returns
    -------
    list of dict
        One per metric, in the order of the first run that has it: ``name``, ``unit``,
        ``bound``, ``bound_kind`` and ``values``, one per run (None where it has none).
    """
    rows: dict[str, dict[str, Any]] = {}
    for number, run in enumerate(_load(paths, labels)):
        for metric in run.metrics:
            row = rows.setdefault(
                metric["name"],
                {
                    "name": metric["name"],
                    "unit": metric["unit"],
                    "bound": metric.get("bound"),
                    "bound_kind": metric.get("bound_kind"),
                    "values": [None] * len(paths),
                },
            )
            row["values"][number] = metric["value"]
    return list(rows.values())


def draw_comparison(
    paths: Sequence[str | Path], labels: Sequence[str], folder: str | Path
) -> list[Path]:
    """Draw the error of each run over time and their metrics side by side.

    Parameters
    ----------
    paths : sequence of Path
        Run folders.
    labels : sequence of str
        What to call each run.
    folder : Path
        Where ``compare.png`` and ``compare.svg`` go.

    Raises
    ------
    ConfigurationError
        There are no runs, or not one label for each.
    """
    runs = _load(paths, labels)
    with paper_style():
        return save(_draw(runs, labels), Path(folder), "compare")


def _load(paths: Sequence[str | Path], labels: Sequence[str]) -> list[RunData]:
    if not paths or len(paths) != len(labels):
        raise ConfigurationError(
            f"a comparison needs runs and one label for each, not {len(paths)} runs and "
            f"{len(labels)} labels"
        )
    return [load_run(path) for path in paths]


def _draw(runs: Sequence[RunData], labels: Sequence[str]) -> "Figure":
    figure = new_figure(PAGE, 26.0 + 24.0 * len(runs))
    grid = figure.add_gridspec(len(runs), 2, width_ratios=[2.2, 1.0])
    errors = [(run.t[run.followed], run.error[run.followed]) for run in runs]
    extent = max(float(np.nanmax(np.abs(error), initial=1e-9)) for _, error in errors)
    factor, unit = length_scale(extent)
    top = None
    for number, ((t, error), run, label) in enumerate(zip(errors, runs, labels, strict=True)):
        axes = figure.add_subplot(grid[number, 0], sharex=top, sharey=top)
        color = PALETTE[number % len(PALETTE)]
        axes.axhline(0.0, color=GREY, lw=0.5)
        axes.plot(*envelope(t, error * factor), color=color, lw=0.7)
        if top is None:
            top = axes
            axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
            axes.set_ylim(-1.08 * extent * factor, 1.08 * extent * factor)
        for segment in run.segments:
            axes.axvspan(segment.start, segment.end, color="#eef2f6", lw=0, zorder=0)
        axes.set_title(label, loc="left", color=color, pad=2.0)
        if number < len(runs) - 1:
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel("time since the reference started (s)")
    if top is not None and runs[0].segments:
        shade_segments(top, PAGE * 0.6, runs[0].segments)
    figure.supylabel(f"error ({unit})", fontsize=8.5)
    _draw_bars(figure.add_subplot(grid[:, 1]), runs, labels)
    return figure


def _draw_bars(axes: Any, runs: Sequence[RunData], labels: Sequence[str]) -> None:
    """Draw each metric that is a length as one group of bars."""
    names = [m["name"] for m in runs[0].metrics if m["unit"] == "m"]
    if not names:
        axes.set_axis_off()
        return
    height = 0.8 / len(runs)
    values = np.array(
        [
            [
                next((m["value"] for m in run.metrics if m["name"] == name), None) or np.nan
                for name in names
            ]
            for run in runs
        ]
    )
    finite = values[np.isfinite(values)]
    factor, unit = length_scale(float(finite.max()) if len(finite) else 0.0)
    for number, label in enumerate(labels):
        rows = np.arange(len(names)) + (number - 0.5 * (len(runs) - 1)) * height
        axes.barh(
            rows, values[number] * factor, height * 0.86,
            color=PALETTE[number % len(PALETTE)], label=label,
        )  # fmt: skip
        for row, value in zip(rows, values[number] * factor, strict=True):
            if np.isfinite(value):
                axes.annotate(
                    f"{value:.3g}", (value, row), (2.5, 0), textcoords="offset points",
                    va="center", fontsize=6.5, zorder=4,
                    bbox={"fc": "white", "ec": "none", "pad": 0.8},
                )  # fmt: skip
    for row, name in enumerate(names):
        metric = next(m for m in runs[0].metrics if m["name"] == name)
        if metric.get("bound") is not None and metric.get("bound_kind") == "max":
            axes.vlines(
                metric["bound"] * factor, row - 0.46, row + 0.46,
                color=INK, lw=0.9, ls=(0, (3, 1.5)),
            )  # fmt: skip
    axes.set_yticks(range(len(names)), labels=[name.replace("_", "\n") for name in names])
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.margins(x=0.16)
    axes.set_xlim(left=0.0)
    axes.set_xlabel(f"metric ({unit}), bound dashed")
