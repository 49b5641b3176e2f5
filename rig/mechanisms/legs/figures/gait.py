"""The figures of the walking legs over time, as their paper draws them and beyond."""

from typing import TYPE_CHECKING

import numpy as np

from rig.mechanisms.legs.figures.base import COLORS, LEGS, is_walk, mark_phases
from rig.mechanisms.legs.figures.contacts import CONTACT_FIGURES
from rig.mechanisms.legs.figures.footsteps import FOOTSTEP_FIGURES
from rig.mechanisms.legs.figures.stance import STANCE_FIGURES
from rig.mechanisms.legs.figures.sway import SWAY_FIGURES
from rig.report.data import RunData
from rig.report.figure import TIME_LABEL, FigureKind, draw_line, finish_time_axis, panels
from rig.report.style import INK, PAGE, new_figure, place_legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NEAR_SINGULAR = 5.0
"""deg; a knee below is near the straight one."""
_PALE = "#b4bdc7"
_MOST_TICKS = 9
"""Instants that have their numbers under half a page."""


def draw_ankle(run: RunData) -> "Figure | None":
    """Draw ankle path, knee angle and knee rate of the swinging leg (the paper's Fig. 2, 3)."""
    if not is_walk(run):
        return None
    swing = next((s for s in run.segments if s.name.startswith("swing left")), None)
    swing = swing or next(s for s in run.segments if s.name.startswith("swing"))
    leg = swing.name.split()[1]
    color = COLORS[leg]
    part = (run.time >= swing.start) & (run.time <= swing.end)
    if np.count_nonzero(part) < 2:
        return None
    figure = new_figure(PAGE, 56.0)
    path, angle, rate = panels(figure, 1, 3)
    x, z = (run.trace(f"reference.{leg}_foot_{axis}")[part] * 1e3 for axis in "xz")
    path.plot(x, z, color=color)
    path.set_xlabel("ahead (mm)")
    path.set_ylabel(f"{leg} ankle, lifted by (mm)")
    t = run.time[part] - swing.start
    # What was measured is a wide line behind; the rate has its servo's steps anyway.
    for axes, quantity, unit, width in (
        (angle, "position", "deg", 2.6),
        (rate, "velocity", "rad/s", 0.8),
    ):
        factor = 180.0 / np.pi if unit == "deg" else 1.0
        measured, commanded = (
            factor * run.trace(f"{source}.{quantity}_{leg}_knee")[part]
            for source in ("reading", "command")
        )
        draw_line(axes, t, measured, _PALE, "measured", lw=width)
        draw_line(axes, t, commanded, color, "commanded")
        axes.set_xlabel(f"time in {swing.name} (s)")
        axes.set_ylabel(f"knee {'angle' if unit == 'deg' else 'rate'} ({unit})")
    _mark_singular(angle, "center", 0.5)
    place_legend(rate, 2)
    return figure


def draw_knees(run: RunData) -> "Figure | None":
    """Draw both knees' rates and angles over the whole motion (the paper's Fig. 4)."""
    if not run.has("command.velocity_right_knee", "reading.position_right_knee"):
        return None
    figure = new_figure(PAGE, 96.0)
    rates, angles = panels(figure, 2, 1, sharex=True)
    t = run.time
    for axes, source, factor in (
        (rates, "command.velocity", 1.0),
        (angles, "command.position", 180.0 / np.pi),
    ):
        right, left = (factor * run.trace(f"{source}_{leg}_knee") for leg in LEGS)
        draw_line(axes, t, right, COLORS["right"], "right knee", lw=0.9)
        # Legs that do the same are both to be seen.
        dashes = (0, (5, 3)) if np.allclose(right, left, atol=1e-3) else "-"
        draw_line(axes, t, left, COLORS["left"], "left knee", lw=0.9, ls=dashes)
    finish_time_axis(rates, t, "knee rate (rad/s)", "")
    finish_time_axis(angles, t, "knee angle (deg)")
    _mark_singular(angles, "left", 0.005)
    for axes in (rates, angles):
        mark_phases(axes, run)
    place_legend(rates, 2)
    return figure


def draw_joints(run: RunData) -> "Figure | None":
    """Draw how far each joint is from where it was sent, and the knees' torques."""
    if not run.has("applied.position_right_knee", "reading.position_right_knee"):
        return None
    joints = ("hip_pitch", "knee", "ankle_pitch")
    has_torque = run.has("truth.torque_right_knee")
    rows = len(joints) + has_torque
    figure = new_figure(PAGE, 14.0 + 26.0 * rows)
    # A column for each leg: what a servo ripples by is a band, and hides whatever is under it.
    grid = panels(figure, rows, 2, sharex=True, sharey="row")
    columns = grid[::2], grid[1::2]
    t = run.time
    for leg, strips in zip(LEGS, columns, strict=True):
        for axes, joint in zip(strips, joints, strict=False):
            name = f"{leg}_{joint}"
            applied, measured = (
                run.trace(f"{source}.position_{name}") for source in ("applied", "reading")
            )
            error = np.degrees(applied - measured)
            draw_line(axes, t, error, COLORS[leg], f"{leg} leg", lw=0.6)
            finish_time_axis(axes, t, f"{joint.replace('_', ' ')}, off\nits setpoint (deg)", "")
        if has_torque:
            torque = run.trace(f"truth.torque_{leg}_knee")
            draw_line(strips[-1], t, torque, COLORS[leg], f"{leg} leg", lw=0.6)
            finish_time_axis(strips[-1], t, "knee torque\n(N m)", "")
        for axes in strips:
            mark_phases(axes, run, most=_MOST_TICKS)
        strips[0].set_title(f"{leg} leg", loc="left")
        strips[-1].set_xlabel(TIME_LABEL)
    for axes in columns[1]:
        axes.set_ylabel("")
    figure.align_ylabels()
    return figure


def _mark_singular(axes: "Axes", side: str, x: float) -> None:
    """Draw the angle below which a knee is near the singularity."""
    axes.axhline(_NEAR_SINGULAR, color=INK, lw=0.6, ls=(0, (4, 2)))
    axes.annotate(
        "near singular below", (x, _NEAR_SINGULAR), xycoords=("axes fraction", "data"),
        xytext=(0, 2), textcoords="offset points", ha=side, fontsize=7,
    )  # fmt: skip


LEGS_FIGURES = {
    "ankle": FigureKind(draw_ankle, "Path of one ankle, knee angle and knee rate in a swing."),
    "knees": FigureKind(draw_knees, "Rates and angles of both knees; swings are shaded."),
    "joints": FigureKind(draw_joints, "Servo errors of the pitch joints, and the knees' torques."),
    **STANCE_FIGURES,
    **CONTACT_FIGURES,
    **SWAY_FIGURES,
    **FOOTSTEP_FIGURES,
}
