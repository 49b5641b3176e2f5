"""The figures of the arm, as its paper draws them and beyond."""

from typing import TYPE_CHECKING

import numpy as np

from controllers.arm.singular_places import singular_places
from rig.mechanisms.arm.boundary import meridian
from rig.mechanisms.arm.limit_figures import draw_accelerations, draw_torques
from rig.mechanisms.arm.singular_band import KINDS, mark_region
from rig.report.data import RunData
from rig.report.envelope import path_envelope
from rig.report.figure import FigureKind, draw_line, finish_time_axis
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
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

JOINTS = ("q1", "q2", "q3", "q4", "q5", "q6")
_INDICES = (
    ("index_shoulder", "shoulder: $c$ (m)"),
    ("index_elbow", "elbow: $S_3$"),
    ("index_wrist", "wrist: $S_5$"),
)
_POSTURES = 9
_ASIDE = 0.25
"""Sine of how far an arm may point aside of x and still be drawn over x."""
_POINTS = ("plan.elbow", "plan.wrist", "reference.hand")


def draw_rates(run: RunData) -> "Figure | None":
    """Draw the commanded joint rates with their limits (as in the paper's Fig. 4 and 6)."""
    if not run.has("command.velocity_q1", "reading.velocity_q1", "plan.index_elbow"):
        return None
    figure = new_figure(PAGE, 92.0)
    panels = figure.subplots(2, 3, sharex=True)
    t = run.time
    limits = run.settings["geometry"]["rate_limits"]
    for axes, name, limit in zip(panels.flat, JOINTS, limits, strict=True):
        measured = run.trace(f"reading.velocity_{name}")
        commanded = run.trace(f"command.velocity_{name}")
        draw_line(axes, t, measured, GREY, "measured", lw=2.0)
        draw_line(axes, t, commanded, BLUE, "commanded", lw=0.9)
        for bound, label in ((-limit, "_"), (limit, "limit")):
            axes.axhline(bound, color=VERMILION, lw=0.8, ls=(0, (5, 2)), label=label)
        mark_region(axes, run)
        finish_time_axis(axes, t, f"{name} (rad/s)", "")
        # A spike beyond three times the permitted rate does not set the scale.
        extent = min(max(1.2, 1.1 * float(np.abs(commanded).max()) / limit), 3.0) * limit
        axes.set_ylim(-extent, extent)
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
    _legend_above(figure, panels[0, 0])
    return figure


def draw_indices(run: RunData) -> "Figure | None":
    """Draw the singularity indices of shoulder, elbow and wrist, planned and measured."""
    if not run.has(*(f"{of}.{name}" for name, _ in _INDICES for of in ("plan", "reading"))):
        return None
    figure = new_figure(PAGE, 50.0)
    panels = figure.subplots(1, 3)
    t = run.time
    for axes, kind, (name, label) in zip(panels, KINDS, _INDICES, strict=True):
        axes.axhline(0.0, color=GREY, lw=0.6)
        draw_line(axes, t, run.trace(f"reading.{name}"), GREY, "measured", lw=2.0)
        draw_line(axes, t, run.trace(f"plan.{name}"), BLUE, "commanded", lw=0.9)
        mark_region(axes, run, (kind,))
        finish_time_axis(axes, t, label, "time (s)")
        _keep_above_noise(axes, 2e-3)
    _legend_above(figure, *panels)
    return figure


def draw_hand(run: RunData) -> "Figure | None":
    """Draw the hand's velocity and angular velocity against what the path asks for."""
    if not run.has("plan.twist_vx", "plan.asked_vx", "reading.twist_vx"):
        return None
    figure = new_figure(PAGE, 88.0)
    panels = figure.subplots(2, 3, sharex=True, sharey="row")
    t = run.time
    kinds = (("v", "v", "m/s"), ("w", r"\omega", "rad/s"))
    for row, (letter, symbol, unit) in zip(panels, kinds, strict=True):
        extent = 0.0
        for axes, axis in zip(row, "xyz", strict=True):
            name = f"{letter}{axis}"
            planned = run.trace(f"plan.twist_{name}")
            asked = run.trace(f"plan.asked_{name}")
            measured = run.trace(f"reading.twist_{name}")
            draw_line(axes, t, measured, GREY, "measured", lw=2.0)
            draw_line(axes, t, planned, BLUE, "commanded: b times what is asked for", lw=0.9)
            draw_line(axes, t, asked, INK, "asked for", lw=0.7, ls=(0, (4, 2)))
            mark_region(axes, run)
            finish_time_axis(axes, t, f"${symbol}_{axis}$ ({unit})", "")
            extent = max(extent, *(float(np.abs(x).max()) for x in (planned, asked)))
        row[0].set_ylim(*(sign * max(1.25 * extent, 0.02) for sign in (-1.0, 1.0)))
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
    _legend_above(figure, panels[0, 0])
    return figure


def draw_inside(run: RunData) -> "Figure | None":
    """Draw how far the wrist is inside the boundary, and how far the hand is off its path."""
    if not run.has("plan.inside", "plan.path_x"):
        return None
    figure = new_figure(PAGE, 58.0)
    left, right = figure.subplots(1, 2)
    t = run.time
    draw_line(left, t, run.trace("plan.inside") * 1e3, BLUE, "wrist centre")
    mark_region(left, run)
    finish_time_axis(left, t, "inside the boundary (mm)", "time (s)")
    source = "truth" if run.has("truth.hand_x") else "reading"
    hand, place, path = (
        run.track(name) for name in (f"{source}.hand", "reference.hand", "plan.path")
    )
    error = hand - path
    ahead = np.gradient(path, axis=0)
    size = np.linalg.norm(ahead, axis=1, keepdims=True)
    unit = np.divide(ahead, size, out=np.zeros_like(ahead), where=size > 1e-12)
    along = ((hand - place) * unit).sum(axis=1)
    across = np.linalg.norm(error - (error * unit).sum(axis=1)[:, None] * unit, axis=1)
    draw_line(right, t, along * 1e3, GREY, "along the path", lw=0.7)
    draw_line(right, t, across * 1e3, VERMILION, "off the path", lw=0.9)
    mark_region(right, run)
    finish_time_axis(right, t, "hand off its place (mm)", "time (s)")
    place_legend(left, 2)
    place_legend(right, 3)
    return figure


def draw_arm(run: RunData) -> "Figure | None":
    """Draw the arm along its path, from the side to which it points and from above."""
    if not run.has("plan.elbow_x", "plan.wrist_x", "reference.hand_x"):
        return None
    figure = new_figure(PAGE, 84.0)
    side, above = figure.subplots(1, 2)
    tracks = [run.track(name) for name in _POINTS]
    chosen = np.linspace(0, len(run.time) - 1, _POSTURES).astype(int)
    geometry = run.settings["geometry"]
    base = float(geometry["base_height"])
    shoulder = _shoulders(run, geometry)
    heading = _heading(tracks[-1])
    for number, k in enumerate(chosen):
        points = np.array([(0.0, 0.0, base), *shoulder[k : k + 1], *(track[k] for track in tracks)])
        shade = 0.85 - 0.75 * number / (_POSTURES - 1)
        color = (shade, shade, shade)
        side.plot(_along(points, heading), points[:, 2], "-o", ms=2.0, lw=1.2, color=color)
        above.plot(points[:, 0], points[:, 1], "-o", ms=2.0, lw=1.2, color=color)
    hand = run.track("reference.hand")
    for axes, x, y in ((side, _along(hand, heading), hand[:, 2]), (above, *hand[:, :2].T)):
        path = path_envelope(x, y)
        axes.plot(*path, color=VERMILION, lw=1.2, label="path of the hand")
    marks = _mark_singularities(run, side, above, _along(hand, heading))
    _draw_boundary(side, base, geometry)
    towards = f"along {np.degrees(heading):.0f} deg about z (m)" if heading else "x (m)"
    for axes, across, label in ((side, towards, "z (m)"), (above, "x (m)", "y (m)")):
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel(across)
        axes.set_ylabel(label)
    above.plot([], [], "-o", ms=2.0, color="#555555", label="arm, light to dark")
    reach = side.get_legend_handles_labels()[0][-1]
    handles = [*above.get_legend_handles_labels()[0], reach, *marks]
    figure.legend(handles=handles, loc="outside upper right", ncols=3, frameon=False)
    return figure


def _heading(hand: "Array") -> float:
    """Return to which side of z the arm points, rad; 0 where that is nearly along x."""
    x, y = hand[:, :2].mean(axis=0)
    heading = float(np.arctan2(y, x))
    return 0.0 if abs(np.sin(heading)) < _ASIDE else heading


def _along(points: "Array", heading: float) -> "Array":
    """Return how far points are along a heading, m."""
    ahead: Array = np.cos(heading) * points[:, 0] + np.sin(heading) * points[:, 1]
    return ahead


def _shoulders(run: RunData, geometry: dict[str, float]) -> "Array":
    """Return the shoulder at each sample, m; none where it is on the axis of q1."""
    ahead, aside = geometry.get("a1", 0.0), geometry["shoulder_offset"]
    if not (ahead or aside) or not run.has("command.position_q1"):
        return np.empty((0, 3))
    q1 = run.trace("command.position_q1")
    c, s = np.cos(q1), np.sin(q1)
    height = np.full(len(q1), geometry["base_height"])
    return np.column_stack((c * ahead - s * aside, s * ahead + c * aside, height))


def _mark_singularities(
    run: RunData, side: "Axes", above: "Axes", along: "Array"
) -> list["Artist"]:
    """Mark on the path where it goes through singularities, filled, or past them; for a legend."""
    joints = [f"command.position_{name}" for name in JOINTS]
    indices = [f"plan.{name}" for name, _ in _INDICES]
    if not run.has(*joints, *indices):
        return []
    x, y, z = run.track("reference.hand").T
    of, q = (np.column_stack([run.trace(name) for name in names]) for names in (indices, joints))
    drawn: dict[str, Artist] = {}
    for place in singular_places(of, q):
        how = "through" if place.through else "past"
        fill = BLUE if place.through else "white"
        marker = {"shoulder": "s", "elbow": "^", "wrist": "o"}[place.kind]
        for axes, across, height in ((side, along, z), (above, x, y)):
            axes.plot(
                across[place.at], height[place.at], marker,
                ms=5.0, mfc=fill, mec=BLUE, mew=1.0, zorder=5,
            )  # fmt: skip
        label = f"{how} the {place.kind}'s singularity"
        if label not in drawn:
            from matplotlib.lines import Line2D

            drawn[label] = Line2D(
                [], [], marker=marker, ls="", ms=5.0, mfc=fill, mec=BLUE, label=label
            )
    return list(drawn.values())


def _draw_boundary(axes: "Axes", base: float, geometry: dict[str, float]) -> None:
    """Draw how far the wrist can get, as far as the picture reaches."""
    from matplotlib.patches import Polygon

    reach = geometry["a2"] + float(np.hypot(geometry["a3"], geometry["elbow_offset"]))
    a1 = abs(geometry.get("a1", 0.0))  # runs of an older program do not say
    outline = meridian(reach, a1, geometry["shoulder_offset"], 256) + np.array((0.0, base))
    edge = Polygon(outline, fill=False, ec=GREY, lw=0.7, ls=(0, (2, 2)))
    axes.add_artist(edge)  # as an artist, not a patch: it does not set the scale
    axes.plot([], [], color=GREY, lw=0.7, ls=(0, (2, 2)), label="reach of the wrist")


def _legend_above(figure: "Figure", *panels: "Axes") -> None:
    """Put one legend above all panels, with each line of any of them once."""
    handles: dict[str, Artist] = {}
    for axes in panels:
        handles |= {label: h for h, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    shown = list(handles.values())
    figure.legend(handles=shown, loc="outside upper right", ncols=min(len(shown), 4), frameon=False)


def _keep_above_noise(axes: "Axes", least: float) -> None:
    """Widen an axis on which nothing happens, so that rounding does not look like a signal."""
    low, high = axes.get_ylim()
    if high - low < least:
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.5 * least, middle + 0.5 * least)


ARM_FIGURES = {
    "rates": FigureKind(
        draw_rates, "Joint rates; limits dashed, shaded in the singular region or near singular."
    ),
    "indices": FigureKind(
        draw_indices,
        "Singularity indices of shoulder, elbow and wrist; shaded in the singular region, or where "
        "the index itself is near singular.",
    ),
    "hand": FigureKind(
        draw_hand,
        "Velocity and angular velocity of the hand against what the path asks for; shaded in the "
        "singular region or near singular.",
    ),
    "inside": FigureKind(
        draw_inside, "Wrist centre inside the workspace's boundary; hand off its place."
    ),
    "accelerations": FigureKind(
        draw_accelerations, "Commanded accelerations of the joints; limits dashed."
    ),
    "torques": FigureKind(
        draw_torques, "Torques that the commanded motion asks of the drives, and their limits."
    ),
    "arm": FigureKind(draw_arm, "The arm along its path from the side and from above."),
}
