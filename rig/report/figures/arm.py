"""The figures of the arm, as its paper draws them and beyond."""

from typing import TYPE_CHECKING, Any

import numpy as np

from rig.report.data import RunData
from rig.report.figures.base import FigureKind, draw_line, finish_time_axis
from rig.report.style import (
    BLUE,
    GREY,
    INK,
    PAGE,
    VERMILION,
    new_figure,
    place_legend,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_JOINTS = ("q1", "q2", "q3", "q4", "q5", "q6")
_INDICES = (
    ("plan.index_shoulder", "c (m)"),
    ("plan.index_elbow", "sin q3"),
    ("plan.index_wrist", "sin q5"),
)
_POSTURES = 9
_POINTS = ("plan.elbow", "plan.wrist", "reference.hand")


def draw_rates(run: RunData) -> "Figure | None":
    """Draw the commanded joint rates with their limits (as in the paper's Fig. 4 and 6)."""
    if not run.has("command.velocity_q1", "reading.velocity_q1", "plan.index_elbow"):
        return None
    figure = new_figure(PAGE, 92.0)
    panels = figure.subplots(2, 3, sharex=True)
    part = run.followed
    t = run.t[part]
    limits = _geometry(run)["rate_limits"]
    for axes, name, limit in zip(panels.flat, _JOINTS, limits, strict=True):
        measured = run.log.column(f"reading.velocity_{name}")[part]
        commanded = run.log.column(f"command.velocity_{name}")[part]
        draw_line(axes, t, measured, GREY, "measured", lw=0.6)
        draw_line(axes, t, commanded, BLUE, "commanded", lw=0.9)
        extent = float(np.abs(commanded).max())
        if extent > 0.5 * limit:
            for bound in (-limit, limit):
                axes.axhline(bound, color=VERMILION, lw=0.8, ls=(0, (5, 2)))
        _mark_region(axes, run)
        finish_time_axis(axes, t, f"{name} (rad/s)")
        axes.set_ylim(*_clipped(axes.get_ylim(), 3.0 * limit))
        axes.set_xlabel("")
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
    place_legend(panels[0, 2], 2)
    return figure


def draw_indices(run: RunData) -> "Figure | None":
    """Draw the singularity indices of shoulder, elbow and wrist."""
    if not run.has(*(name for name, _ in _INDICES)):
        return None
    figure = new_figure(PAGE, 46.0)
    panels = figure.subplots(1, 3)
    part = run.followed
    t = run.t[part]
    for axes, (name, label) in zip(panels, _INDICES, strict=True):
        axes.axhline(0.0, color=GREY, lw=0.6)
        draw_line(axes, t, run.log.column(name)[part], BLUE, label)
        _mark_region(axes, run)
        finish_time_axis(axes, t, label)
        axes.set_xlabel("time (s)")
    return figure


def draw_hand(run: RunData) -> "Figure | None":
    """Draw the hand's speed and turn rate against what the path asks for."""
    if not run.has("plan.speed", "plan.commanded_speed"):
        return None
    figure = new_figure(PAGE, 62.0)
    left, right = figure.subplots(1, 2)
    part = run.followed
    t = run.t[part]
    for axes, name, label in (
        (left, "speed", "speed of the hand (m/s)"),
        (right, "turn_rate", "turn rate of the hand (rad/s)"),
    ):
        draw_line(axes, t, run.log.column(f"plan.{name}")[part], BLUE, "hand", lw=1.0)
        asked = run.log.column(f"plan.commanded_{name}")[part]
        draw_line(axes, t, asked, INK, "asked for", lw=0.7, ls=(0, (4, 2)))
        _mark_region(axes, run)
        finish_time_axis(axes, t, label)
        axes.set_xlabel("time (s)")
    place_legend(left, 2)
    return figure


def draw_inside(run: RunData) -> "Figure | None":
    """Draw how far the wrist is inside the boundary, and how far the hand is off its path."""
    if not run.has("plan.inside", "reference.hand_x"):
        return None
    figure = new_figure(PAGE, 58.0)
    left, right = figure.subplots(1, 2)
    part = run.followed
    t = run.t[part]
    draw_line(left, t, run.log.column("plan.inside")[part] * 1e3, BLUE, "wrist centre")
    _mark_region(left, run)
    finish_time_axis(left, t, "inside the boundary (mm)")
    left.set_xlabel("time (s)")
    source = "truth" if run.has("truth.hand_x") else "reading"
    error = np.column_stack(
        [
            run.log.column(f"{source}.hand_{axis}") - run.log.column(f"reference.hand_{axis}")
            for axis in "xyz"
        ]
    )[part]
    ahead = np.gradient(
        np.column_stack([run.log.column(f"reference.hand_{axis}")[part] for axis in "xyz"]), axis=0
    )
    size = np.linalg.norm(ahead, axis=1, keepdims=True)
    unit = np.divide(ahead, size, out=np.zeros_like(ahead), where=size > 1e-12)
    along = (error * unit).sum(axis=1)
    across = np.linalg.norm(error - along[:, None] * unit, axis=1)
    draw_line(right, t, along * 1e3, GREY, "along the path", lw=0.7)
    draw_line(right, t, across * 1e3, VERMILION, "off the path", lw=0.9)
    _mark_region(right, run)
    finish_time_axis(right, t, "hand off its place (mm)")
    right.set_xlabel("time (s)")
    place_legend(right, 2)
    return figure


def draw_arm(run: RunData) -> "Figure | None":
    """Draw the arm along its path, from the side and from above."""
    if not run.has("plan.elbow_x", "plan.wrist_x", "reference.hand_x"):
        return None
    figure = new_figure(PAGE, 84.0)
    side, above = figure.subplots(1, 2)
    followed = np.flatnonzero(run.followed)
    chosen = followed[np.linspace(0, len(followed) - 1, _POSTURES).astype(int)]
    base = float(_geometry(run)["base_height"])
    for number, k in enumerate(chosen):
        points = np.array([(0.0, 0.0, base), *(_point(run, name, int(k)) for name in _POINTS)])
        shade = 0.85 - 0.75 * number / (_POSTURES - 1)
        color = (shade, shade, shade)
        side.plot(points[:, 0], points[:, 2], "-o", ms=2.0, lw=1.2, color=color)
        above.plot(points[:, 0], points[:, 1], "-o", ms=2.0, lw=1.2, color=color)
    x, y, z = (run.log.column(f"reference.hand_{axis}")[run.followed] for axis in "xyz")
    side.plot(x, z, color=VERMILION, lw=1.2, label="path of the hand")
    above.plot(x, y, color=VERMILION, lw=1.2, label="path of the hand")
    for axes, label in ((side, "z (m)"), (above, "y (m)")):
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("x (m)")
        axes.set_ylabel(label)
    side.plot([], [], "-o", ms=2.0, color="#555555", label="arm, light to dark")
    place_legend(side, 2)
    return figure


def _point(run: RunData, name: str, sample: int) -> tuple[float, float, float]:
    x, y, z = (float(run.log.column(f"{name}_{axis}")[sample]) for axis in "xyz")
    return x, y, z


def _mark_region(axes: Any, run: RunData) -> None:
    """Mark where the singular region is entered and left, as the paper does, by black lines."""
    for segment in run.segments:
        if segment.name == "region":
            for instant in (segment.start, segment.end):
                axes.axvline(instant, color=INK, lw=0.8)


def _clipped(limits: tuple[float, float], extent: float) -> tuple[float, float]:
    """Return axis limits that a spike beyond three times the permitted rate does not set."""
    return max(limits[0], -extent), min(limits[1], extent)


def _geometry(run: RunData) -> dict[str, Any]:
    """Return the arm's dimensions and limits from the run's own profile."""
    import yaml

    profile = yaml.safe_load((run.folder.path / "profile.yaml").read_text(encoding="utf-8"))
    geometry: dict[str, Any] = profile["arm"]["geometry"]
    return geometry


ARM_FIGURES = {
    "rates": FigureKind(
        draw_rates, "Joint rates; limits dashed, black lines where the region is entered and left."
    ),
    "indices": FigureKind(draw_indices, "Singularity indices of shoulder, elbow and wrist."),
    "hand": FigureKind(draw_hand, "Speed and turn rate of the hand against what was asked for."),
    "inside": FigureKind(
        draw_inside, "Wrist centre inside the workspace's boundary; hand off its place."
    ),
    "arm": FigureKind(draw_arm, "The arm along its path from the side and from above."),
}
