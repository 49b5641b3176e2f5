"""The figures of an antagonistic pair."""

from typing import TYPE_CHECKING

import numpy as np

from rig.experiment.measure import local_slope
from rig.report.data import RunData
from rig.report.envelope import path_envelope
from rig.report.figure import TIME_LABEL, FigureKind, bounds_of, draw_line, finish_time_axis
from rig.report.repeatability import draw_repeatability, places_of, visits_of
from rig.report.style import (
    BLUE,
    COLUMN,
    GREY,
    INK,
    PAGE,
    PALE,
    PALETTE,
    VERMILION,
    format_length,
    length_scale,
    new_figure,
    place_legend,
    segment_label,
    shade_segments,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TRACKING_MEASURES = {"tracking_rms", "tracking_max", "hold_rms", "hold_max"}


def draw_tracking(run: RunData) -> "Figure | None":
    """Draw reference and reading over time."""
    if not run.has("reference.position", "reading.position"):
        return None
    figure = new_figure(PAGE, 62.0)
    axes = figure.add_subplot()
    t = run.time
    for name, label, color, width in (
        ("reading.position", "reading", BLUE, 1.0),
        ("reference.position", "reference", INK, 0.7),
    ):
        style = "-" if label == "reading" else (0, (4, 2))
        draw_line(axes, t, run.trace(name) * 1e3, color, label, lw=width, ls=style)
    finish_time_axis(axes, t, "position (mm)")
    shade_segments(axes, PAGE, run.segments)
    place_legend(axes, 2)
    return figure


def draw_error(run: RunData) -> "Figure | None":
    """Draw the tracking error over time with the bounds that it is held against."""
    if not run.has("reference.position", "reading.position"):
        return None
    figure = new_figure(PAGE, 62.0)
    axes = figure.add_subplot()
    t, error = run.time, run.error[run.followed]
    bounds = list(bounds_of(run, _TRACKING_MEASURES))
    extent = max([float(np.abs(error).max()), *(bound for _, bound, _ in bounds)])
    factor, unit = length_scale(extent)
    axes.axhline(0.0, color=GREY, lw=0.5)
    draw_line(axes, t, error * factor, BLUE, "error (reference − reading)", lw=0.7)
    finish_time_axis(axes, t, f"error ({unit})")
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
        if f"applied.{chamber}" in run.log:
            applied = run.log.column(f"applied.{chamber}") * 1e-3
            draw_line(axes, t, applied, PALE, "setpoint", lw=0.5)
        draw_line(axes, t, measured, BLUE, "measured", lw=0.9)
        axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
        axes.set_ylabel(f"{chamber} (kPa)")
        if number == 0:
            place_legend(axes, 2)
    panels[-1].set_xlabel(TIME_LABEL)
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
                *path_envelope(velocity[part], difference[part]), color=color, lw=0.5, alpha=0.8,
                label=name, rasterized=True,
            )  # fmt: skip
    axes.set_xlabel("velocity (mm/s)")
    axes.set_ylabel("agonist − antagonist pressure (kPa)")
    if axes.lines:
        place_legend(axes, min(3, len(axes.lines)))
    return figure


def draw_pair_repeatability(run: RunData) -> "Figure | None":
    """Draw where the pair ended at levels that were gone to several times."""
    if not run.has("reference.position", "reading.position"):
        return None
    wanted, reached = (run.trace(f"{of}.position")[:, None] for of in ("reference", "reading"))
    places = places_of(
        visits_of(run, wanted, reached),
        lambda visit: visit.end - visit.target,
        lambda visit: segment_label(visit.name).removeprefix("hold "),
    )
    return draw_repeatability(places, ("off their mean",))


PAIR_FIGURES = {
    "tracking": FigureKind(
        draw_tracking, "Reference and reading of the position; the shaded stretches are judged."
    ),
    "error": FigureKind(
        draw_error, "Tracking error, with the rms over each judged stretch and the bounds."
    ),
    "pressures": FigureKind(
        draw_pressures, "Setpoints as sent and pressures as monitored (gauge)."
    ),
    "repeatability": FigureKind(
        draw_pair_repeatability,
        "Where each visit of a level ended that was gone to several times, about their mean; "
        "dashed, where 95 % of further ones end. AP and RP: as in ISO 9283.",
    ),
    "phase": FigureKind(
        draw_phase,
        "Pressure difference over velocity: the jump where it changes sign is friction.",
    ),
}


def _pressure_columns(run: RunData) -> tuple[str, ...]:
    return run.log.names("reading.pressure_")
