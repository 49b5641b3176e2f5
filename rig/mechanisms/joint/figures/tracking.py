"""The figures of the spherical joint, as its paper draws them and beyond."""

import re
from typing import TYPE_CHECKING

import numpy as np

from rig.experiment.measure import local_slope
from rig.mechanisms.joint.measures.tracking import CHANNELS, PAIRS
from rig.report.data import RunData
from rig.report.envelope import path_envelope
from rig.report.figure import TIME_LABEL, FigureKind, bounds_of, draw_line, finish_time_axis
from rig.report.frequency_figure import draw_response
from rig.report.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    PAGE,
    PALE,
    PALETTE,
    VERMILION,
    length_scale,
    new_figure,
    place_legend,
    shade_segments,
)

_SLOW = 1e-3
"""While the marker moves no faster (m/s) nobody asks how much the channels stick."""

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from rig.hal.motion import Segment

    Array = NDArray[np.float64]


def draw_channels(run: RunData) -> "Figure | None":
    """Draw reference, position and pressure of each channel (the paper's Fig. 11 to 14)."""
    if not run.has("reading.rod_ch1", "reading.pressure_ch1"):
        return None
    figure = new_figure(PAGE, 128.0)
    grid = figure.subplots(len(CHANNELS), 2, sharex=True, sharey="col")
    t = run.time
    for row, name in zip(grid, CHANNELS, strict=True):
        position, pressure = row
        reading = run.trace(f"reading.rod_{name}") * 1e3
        desired = run.trace(f"reference.rod_{name}") * 1e3
        draw_line(position, t, reading, BLUE, "reading", lw=1.0)
        draw_line(position, t, desired, INK, "reference", lw=0.6, ls=(0, (4, 2)))
        position.set_ylabel(f"{name} (mm)")
        measured = run.trace(f"reading.pressure_{name}") * 1e-3
        applied = run.trace(f"applied.{name}") * 1e-3
        draw_line(pressure, t, applied, PALE, "setpoint", lw=0.4)
        draw_line(pressure, t, measured, BLUE, "monitored", lw=0.8)
        pressure.set_ylabel("(kPa)")
        for axes in row:
            axes.set_xlim(float(t[0]), float(2.0 * t[-1] - t[-2]))
    grid[0, 0].set_title("shortening of the wire", loc="left")
    grid[0, 1].set_title("pressure, gauge", loc="left")
    for axes in grid[0]:
        place_legend(axes, 2)
    for axes in grid[-1]:
        axes.set_xlabel(TIME_LABEL)
    return figure


def draw_marker_track(run: RunData) -> "Figure | None":
    """Draw the marker's track over its target, seen along the axis (the paper's Fig. 15)."""
    if not run.has("reference.marker_x", "estimate.marker_x"):
        return None
    shown = _whole(run)[:4] or None
    figure = new_figure(PAGE, 84.0)
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.05])
    source = "truth" if run.has("truth.marker_x") else "estimate"
    x, y, _ = (run.track(f"{source}.marker") * 1e3).T
    u, v, _ = (run.track("reference.marker") * 1e3).T
    t = run.time
    windows = (
        [(s.name, (t >= s.start) & (t < s.end)) for s in shown]
        if shown
        else [("all", np.ones(len(t), bool))]
    )
    left.plot(*path_envelope(u, v), color=INK, lw=0.8, ls=(0, (4, 2)), label="target", zorder=3)
    for (name, part), color in zip(windows, PALETTE, strict=False):
        if not part.any():
            continue
        left.plot(*path_envelope(x[part], y[part]), color=color, lw=0.7, label=name)
        azimuth = np.degrees(np.arctan2(v[part], u[part]))
        radial = np.hypot(x[part], y[part]) - np.hypot(u[part], v[part])
        along, off = path_envelope(azimuth, radial)
        order = np.argsort(along)
        right.plot(along[order], off[order], ".", ms=0.6, color=color, alpha=0.5, rasterized=True)
        right.plot([], [], color=color, label=f"{name}: rms {_micro(radial)}")
    left.set_aspect("equal")
    left.set_xlabel("x (mm)")
    left.set_ylabel("y (mm)")
    place_legend(left, 4)
    right.axhline(0.0, color=GREY, lw=0.5)
    right.set_xlim(-180.0, 180.0)
    right.set_xticks([-180, -90, 0, 90, 180])
    right.set_xlabel("azimuth of the target (deg)")
    right.set_ylabel("radial error (mm)")
    place_legend(right, 2)
    return figure


def draw_joint_error(run: RunData) -> "Figure | None":
    """Draw the errors of both pairs and of the marker, with their bounds."""
    if not run.has("reference.rod_ch1", "reading.rod_ch1"):
        return None
    # A good estimate lies on the truth, and would hide it: each has a panel.
    markers = [
        (label, color, run.track(f"{source}.marker"))
        for source, label, color in (
            ("truth", "true marker", VERMILION),
            ("estimate", "estimated marker", GREEN),
        )
        if run.has(f"{source}.marker_x")
    ]
    figure = new_figure(PAGE, 82.0 + 32.0 * len(markers))
    rows = figure.subplots(2 + len(markers), 1, sharex=True)
    panels, lower = rows[:2], rows[2:]
    t = run.time
    errors = [0.5 * (_rod_error(run, one) - _rod_error(run, other)) for one, other in PAIRS]
    factor, unit = length_scale(max(float(np.abs(error).max()) for error in errors))
    for axes, error, (one, other) in zip(panels, errors, PAIRS, strict=True):
        axes.axhline(0.0, color=GREY, lw=0.5)
        draw_line(axes, t, error * factor, BLUE, f"{one} against {other}", lw=0.7)
        finish_time_axis(axes, t, f"pair error ({unit})", "")
        _draw_bounds(axes, run, {"wire_rms", "wire_hold_rms"}, factor)
        place_legend(axes, 3)
    least, most = zip(*(axes.get_ylim() for axes in panels), strict=True)
    for axes in panels:
        axes.set_ylim(min(least), max(most))
    shade_segments(panels[0], PAGE, [_brief(segment) for segment in _whole(run)])
    desired = run.track("reference.marker")
    distances = [np.linalg.norm(track - desired, axis=1) for _, _, track in markers]
    extent = max((float(distance.max()) for distance in distances), default=0.0)
    factor, unit = length_scale(extent)
    for axes, (label, color, _), distance in zip(lower, markers, distances, strict=True):
        draw_line(axes, t, distance * factor, color, label, lw=0.7)
        finish_time_axis(axes, t, f"off its target ({unit})", "")
        axes.set_ylim(0.0, 1.08 * factor * extent)
        _draw_bounds(axes, run, {"marker_rms"}, factor)
        place_legend(axes, 3)
    rows[-1].set_xlabel(TIME_LABEL)
    figure.align_ylabels()
    return figure


def draw_tensions(run: RunData) -> "Figure | None":
    """Draw the tension of each wire with its least value, and how much of the time it sticks."""
    source = "truth" if run.has("truth.tension_ch1") else "estimate"
    if not run.has(f"{source}.tension_ch1"):
        return None
    has_stick = run.has("truth.sticking_ch1") and _wanted_speed(run) > _SLOW
    figure = new_figure(PAGE, 66.0)
    grid = figure.add_gridspec(1, 4)
    axes = figure.add_subplot(grid[0, :3] if has_stick else grid[0, :])
    t = run.time
    for name, color in zip(CHANNELS, PALETTE, strict=False):
        draw_line(axes, t, run.trace(f"{source}.tension_{name}"), color, name, lw=0.7)
    label = "bound"
    for metric in run.metrics:
        bound = metric.get("bound")
        if bound and metric.get("measure") in ("tension_min", "tension_max"):
            axes.axhline(bound, color=INK, lw=0.8, ls=(0, (5, 2)), label=label)
            label = "_"
    finish_time_axis(axes, t, "tension (N)")
    axes.set_ylim(bottom=0.0)
    shade_segments(axes, PAGE * 0.7, [_brief(segment) for segment in _whole(run)])
    place_legend(axes, 5)
    if has_stick:
        _draw_sticking(figure.add_subplot(grid[0, 3]), run)
    return figure


def _draw_sticking(axes: "Axes", run: RunData) -> None:
    """Draw the share of the time in which each channel sticks though it should move."""
    shares = []
    for name in CHANNELS:
        speed = np.abs(local_slope(run.t, run.log.column(f"reference.rod_{name}")))
        moving = run.followed & (speed > 0.3 * speed[run.followed].max())
        sticks = run.log.column(f"truth.sticking_{name}") > 0.5
        shares.append(100.0 * float(np.mean(sticks[moving])) if moving.any() else 0.0)
    axes.bar(range(len(CHANNELS)), shares, color=PALETTE[: len(CHANNELS)], width=0.7)
    axes.set_xticks(range(len(CHANNELS)), labels=CHANNELS)
    axes.set_ylabel("sticks while it should move (%)")
    axes.grid(axis="x", visible=False)


def _draw_bounds(axes: "Axes", run: RunData, measures: set[str], factor: float) -> None:
    label = "bound on the rms"
    for _, bound, segments in bounds_of(run, measures):
        for segment in segments:
            axes.hlines(
                bound * factor, segment.start, segment.end,
                color=INK, lw=0.9, ls=(0, (5, 2)), label=label,
            )  # fmt: skip
            label = "_"


def _whole(run: RunData) -> "list[Segment]":
    """Return the segments that are no part of another one but the whole."""
    parts = [segment for segment in run.segments if segment.name != "all"]
    return [
        inner
        for inner in parts
        if not any(
            outer is not inner and outer.start <= inner.start and inner.end <= outer.end
            for outer in parts
        )
    ]


def _brief(segment: "Segment") -> "Segment":
    """Return a segment by a name that fits over a short stretch: a pose by its two angles."""
    name = re.sub(r"^hold (\S+) deg at (\S+) deg.*$", r"\1°, \2°", segment.name)
    return segment._replace(name=name)


def _wanted_speed(run: RunData) -> float:
    """Return how fast the marker is to move at most, m/s."""
    ways = run.track("reference.marker").T
    return max(float(np.abs(local_slope(run.time, way)).max()) for way in ways)


def _rod_error(run: RunData, name: str) -> "Array":
    return run.trace(f"reference.rod_{name}") - run.trace(f"reading.rod_{name}")


def _micro(error: "Array") -> str:
    return f"{1e3 * float(np.sqrt(np.mean(error**2))):.0f} µm"


def draw_joint_response(run: RunData) -> "Figure | None":
    """Draw gain and phase of each wire in each circle: there every wire's reference is a sine."""
    columns = {name: (f"reference.rod_{name}", f"reading.rod_{name}") for name in CHANNELS}
    return draw_response(run, columns)


JOINT_FIGURES = {
    "channels": FigureKind(
        draw_channels, "Shortening of each wire with its reference, and the chamber pressures."
    ),
    "marker-track": FigureKind(
        draw_marker_track,
        "Track of the marker over its target seen along the axis, and its radial error.",
    ),
    "joint-error": FigureKind(
        draw_joint_error, "Errors of the two wire pairs and of the marker, with their bounds."
    ),
    "frequency-response": FigureKind(
        draw_joint_response, "Gain and phase of each wire over its reference in each circle."
    ),
    "tensions": FigureKind(
        draw_tensions, "Tension of each wire; how much of the time a channel sticks."
    ),
}
