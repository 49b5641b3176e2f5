"""The figures of one run, drawn from its folder alone."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rig.experiment.measures import local_slope
from rig.report.data import RunData, load_run
from rig.report.envelope import envelope
from rig.report.style import (
    BLUE,
    COLUMN,
    GREY,
    INK,
    PAGE,
    PALETTE,
    VERMILION,
    format_length,
    length_scale,
    new_figure,
    paper_style,
    place_legend,
    save,
    segment_label,
    shade_segments,
)
from rig.report.timing import STAGES, has_timing, stage_times
from rig.run_folder import FIGURES as FIGURES_FOLDER

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TIME_LABEL = "time since the reference started (s)"
_TRACKING_MEASURES = {"tracking_rms", "tracking_max", "hold_rms", "hold_max"}


def draw_figures(path: str | Path, names: Iterable[str] | None = None) -> list[Path]:
    """Draw a run's figures into its folder, as PNG and SVG.

    A figure whose quantities the log does not hold is left out.

    Parameters
    ----------
    path : Path
        The run folder.
    names : iterable of str, optional
        Keys of `FIGURES`; default: all.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    ValueError
        A figure is unknown.
    ConfigurationError, LogError
        There is no run folder, or no log in it.
    """
    chosen = list(FIGURES) if names is None else list(names)
    for name in chosen:
        if name not in FIGURES:
            raise ValueError(f"there is no figure {name!r}; there are {', '.join(FIGURES)}")
    run = load_run(path)
    written: list[Path] = []
    if len(run.log.t) < 2:
        return written
    with paper_style():
        for name in chosen:
            figure = FIGURES[name](run)
            if figure is not None:
                written += save(figure, run.folder.path / FIGURES_FOLDER, name)
    return written


def draw_tracking(run: RunData) -> "Figure | None":
    """Draw reference and reading over time."""
    if not _has(run, "reference.position", "reading.position"):
        return None
    figure = new_figure(PAGE, 62.0)
    axes = figure.add_subplot()
    part = run.followed
    t = run.t[part]
    for name, label, color, width in (
        ("reading.position", "reading", BLUE, 1.0),
        ("reference.position", "reference", INK, 0.7),
    ):
        style = "-" if label == "reading" else (0, (4, 2))
        _line(axes, t, run.log.column(name)[part] * 1e3, color, label, lw=width, ls=style)
    _finish_time_axis(axes, t, "position (mm)")
    shade_segments(axes, PAGE, run.segments)
    place_legend(axes, 2)
    return figure


def draw_error(run: RunData) -> "Figure | None":
    """Draw the tracking error over time with the bounds that it is held against."""
    if not _has(run, "reference.position", "reading.position"):
        return None
    figure = new_figure(PAGE, 62.0)
    axes = figure.add_subplot()
    part = run.followed
    t, error = run.t[part], run.error[part]
    bounds = list(_length_bounds(run))
    extent = max([float(np.abs(error).max()), *(bound for _, bound, _ in bounds)])
    factor, unit = length_scale(extent)
    axes.axhline(0.0, color=GREY, lw=0.5)
    _line(axes, t, error * factor, BLUE, "error (reference − reading)", lw=0.7)
    _finish_time_axis(axes, t, f"error ({unit})")
    notes = []
    for segment in run.segments:
        inside = error[(t >= segment.start) & (t < segment.end)]
        if t[-1] < segment.end - 2.0 * (t[-1] - t[-2]):
            notes.append("incomplete")
        else:
            notes.append(f"rms {format_length(float(np.sqrt(np.mean(inside**2))))}")
    styles = {"rms": (0, (5, 2)), "max": (0, (1.2, 1.2))}
    shown: set[str] = set()
    for metric, bound, segments in bounds:
        kind = "rms" if metric["measure"].endswith("rms") else "max"
        for segment in segments:
            axes.hlines(
                [-bound * factor, bound * factor],
                segment.start,
                segment.end,
                color=VERMILION,
                lw=0.9,
                ls=styles[kind],
                label=f"bound on the {kind} error" if kind not in shown else "_",
            )
            shown.add(kind)
    shade_segments(axes, PAGE, run.segments, notes)
    place_legend(axes, 3)
    return figure


def draw_pressures(run: RunData) -> "Figure | None":
    """Draw set and measured pressures, one panel per chamber."""
    chambers = [name.removeprefix("reading.pressure_") for name in _pressure_columns(run)]
    if not chambers:
        return None
    figure = new_figure(PAGE, 18.0 + 34.0 * len(chambers))
    panels = figure.subplots(len(chambers), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    t = run.t
    for number, (axes, chamber) in enumerate(zip(panels, chambers, strict=True)):
        measured = run.log.column(f"reading.pressure_{chamber}") * 1e-3
        _line(axes, t, measured, BLUE, "measured", lw=0.9)
        if f"applied.{chamber}" in run.log:
            applied = run.log.column(f"applied.{chamber}") * 1e-3
            _line(axes, t, applied, VERMILION, "setpoint", lw=0.6)
        axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
        axes.set_ylabel(f"{chamber} (kPa)")
        if number == 0:
            place_legend(axes, 2)
    panels[-1].set_xlabel(_TIME_LABEL)
    return figure


def draw_phase(run: RunData) -> "Figure | None":
    """Draw the pressure difference that a velocity takes: friction and its hysteresis."""
    chambers = _pressure_columns(run)
    if len(chambers) != 2 or "reading.position" not in run.log:
        return None
    figure = new_figure(COLUMN, 72.0)
    axes = figure.add_subplot()
    t = run.t
    velocity = local_slope(t, run.log.column("reading.position")) * 1e3
    difference = (run.log.column(chambers[0]) - run.log.column(chambers[1])) * 1e-3
    shown = run.segments[: len(PALETTE)]
    parts = [(t >= s.start) & (t < s.end) & run.followed for s in shown] or [run.followed]
    names = [segment_label(segment.name) for segment in shown] or ["all cycles"]
    for part, name, color in zip(parts, names, PALETTE, strict=False):
        if part.any():
            axes.plot(
                velocity[part], difference[part], color=color, lw=0.5, alpha=0.8, label=name,
                rasterized=True,
            )  # fmt: skip
    axes.set_xlabel("velocity (mm/s)")
    axes.set_ylabel("agonist − antagonist pressure (kPa)")
    if axes.lines:
        place_legend(axes, min(3, len(axes.lines)))
    return figure


def draw_timing(run: RunData) -> "Figure | None":
    """Draw what each stage of the cycle costs and how long whole cycles were."""
    if not has_timing(run.log):
        return None
    figure = new_figure(PAGE, 60.0)
    left, right = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
    times = stage_times(run.log) * 1e6
    rows = np.arange(len(STAGES))
    share = times.sum(axis=0) / max(float(times.sum()), 1e-12)
    median, p99 = np.percentile(times, [50.0, 99.0], axis=0)
    longest = times.max(axis=0)
    left.hlines(rows, median, longest, color="#c9d3dc", lw=2.2, zorder=1)
    left.plot(median, rows, "o", color=BLUE, ms=4, label="median")
    left.plot(p99, rows, "|", color=INK, ms=8, mew=1.2, label="99 %")
    left.plot(longest, rows, "D", color=VERMILION, ms=2.6, label="longest")
    labels = [f"{s}  {100 * p:.0f} %" for s, p in zip(STAGES, share, strict=True)]
    left.set_yticks(rows, labels=labels)
    left.set_ylim(len(STAGES) - 0.5, -0.5)
    left.grid(axis="y", visible=False)
    left.set_xscale("log")
    left.set_xlabel("time per cycle (µs)")
    left.set_ylabel("stage and its share")
    place_legend(left, 3)

    work = times.sum(axis=1)
    lateness = run.log.column("timing.lateness") * 1e6
    period = float(np.median(work + run.log.column("timing.slack") * 1e6))
    top = max(float(work.max()), period)
    late = lateness[lateness > 0.0]  # on a virtual clock no cycle is late
    bottom = min([float(work.min()), *np.percentile(late, [1.0])] if len(late) else [work.min()])
    bins = np.geomspace(max(bottom, 0.1), top * 1.05, 60)
    right.hist(work, bins=bins, histtype="stepfilled", color=PALETTE[5], label="work")
    if len(late):
        right.hist(
            np.maximum(late, bins[0]),
            bins=bins,
            histtype="step",
            color=VERMILION,
            lw=0.9,
            label="lateness",
        )
    right.axvline(period, color=INK, lw=0.8, ls=(0, (4, 2)), label="period")
    right.set_xscale("log")
    right.set_yscale("log")
    right.set_xlabel("time (µs)")
    right.set_ylabel("cycles")
    place_legend(right, 3)
    return figure


FIGURES: "dict[str, Callable[[RunData], Figure | None]]" = {
    "tracking": draw_tracking,
    "error": draw_error,
    "pressures": draw_pressures,
    "phase": draw_phase,
    "timing": draw_timing,
}
CAPTIONS = {
    "tracking": "Reference and reading of the position; the shaded stretches are judged.",
    "error": "Tracking error, with the rms over each judged stretch and the bounds.",
    "pressures": "Setpoints as sent and pressures as monitored (gauge).",
    "phase": "Pressure difference over velocity: the jump where it changes sign is friction.",
    "timing": "What each stage of the cycle costs, and how long whole cycles took.",
}


def _has(run: RunData, *names: str) -> bool:
    return all(name in run.log for name in names)


def _pressure_columns(run: RunData) -> tuple[str, ...]:
    return run.log.names("reading.pressure_")


def _line(axes: "Axes", t: Any, x: Any, color: str, label: str, **style: Any) -> None:
    axes.plot(*envelope(t, x), color=color, label=label, solid_joinstyle="round", **style)


def _finish_time_axis(axes: "Axes", t: Any, label: str) -> None:
    axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
    axes.margins(y=0.08)
    axes.set_xlabel(_TIME_LABEL)
    axes.set_ylabel(label)


def _length_bounds(run: RunData) -> Iterable[tuple[dict[str, Any], float, list[Any]]]:
    """Yield the metrics that bound the error, their bound in m and their segments."""
    from fnmatch import fnmatchcase

    for metric in run.metrics:
        if (
            metric.get("measure") in _TRACKING_MEASURES
            and metric.get("bound_kind") == "max"
            and metric.get("bound") is not None
        ):
            pattern = metric.get("segments", "*")
            yield (
                metric,
                metric["bound"],
                [segment for segment in run.segments if fnmatchcase(segment.name, pattern)],
            )
