"""The figures of the walking legs, as their paper draws them and beyond."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from rig.report.data import RunData
from rig.report.figures.base import TIME_LABEL, FigureKind, draw_line, finish_time_axis
from rig.report.style import (
    BLUE,
    GREY,
    INK,
    PAGE,
    SHADE,
    VERMILION,
    new_figure,
    place_legend,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_LEGS = ("right", "left")
_COLORS = {"right": VERMILION, "left": BLUE}
_NEAR_SINGULAR = 5.0
"""deg; a knee below is near the straight one."""
_SINGULAR_TIMES = (18.0, 20.0, 22.0, 24.0, 27.0, 29.0, 31.0, 33.0)
"""s; of the photographs in the paper's Fig. 5."""


def draw_ankle(run: RunData) -> "Figure | None":
    """Draw ankle path, knee angle and knee rate of the swinging leg (the paper's Fig. 2, 3)."""
    if not _is_walk(run):
        return None
    swing = next((s for s in run.segments if s.name.startswith("swing left")), None)
    swing = swing or next((s for s in run.segments if s.name.startswith("swing")), None)
    if swing is None:
        return None
    leg = swing.name.split()[1]
    part = run.followed & (run.t >= swing.start) & (run.t <= swing.end)
    if np.count_nonzero(part) < 2:
        return None
    figure = new_figure(PAGE, 56.0)
    path, angle, rate = figure.subplots(1, 3)
    x, z = (run.log.column(f"reference.{leg}_foot_{axis}")[part] * 1e3 for axis in "xz")
    path.plot(x, z, color=_COLORS[leg])
    path.set_xlabel("x (mm)")
    path.set_ylabel(f"{leg} sole above the ground (mm)")
    t = run.t[part] - swing.start
    knee = np.degrees(run.log.column(f"command.position_{leg}_knee")[part])
    measured = np.degrees(run.log.column(f"reading.position_{leg}_knee")[part])
    draw_line(angle, t, measured, GREY, "measured", lw=0.8)
    draw_line(angle, t, knee, _COLORS[leg], "commanded")
    angle.set_ylabel("knee angle (deg)")
    speed = run.log.column(f"command.velocity_{leg}_knee")[part]
    draw_line(rate, t, speed, _COLORS[leg], "commanded")
    rate.set_ylabel("knee rate (rad/s)")
    for axes in (angle, rate):
        axes.set_xlabel(f"time in {swing.name} (s)")
    place_legend(angle, 2)
    return figure


def draw_knees(run: RunData) -> "Figure | None":
    """Draw both knees' rates and angles over the whole motion (the paper's Fig. 4)."""
    if not run.has("command.velocity_right_knee", "reading.position_right_knee"):
        return None
    figure = new_figure(PAGE, 96.0)
    rates, angles = figure.subplots(2, 1, sharex=True)
    part = run.followed
    t = run.t[part]
    for leg in _LEGS:
        rate = run.log.column(f"command.velocity_{leg}_knee")[part]
        angle = np.degrees(run.log.column(f"command.position_{leg}_knee")[part])
        draw_line(rates, t, rate, _COLORS[leg], f"{leg} knee", lw=0.8)
        draw_line(angles, t, angle, _COLORS[leg], f"{leg} knee", lw=0.9)
    finish_time_axis(rates, t, "knee rate (rad/s)")
    rates.set_xlabel("")
    finish_time_axis(angles, t, "knee angle (deg)")
    angles.axhline(_NEAR_SINGULAR, color=INK, lw=0.6, ls=(0, (4, 2)))
    angles.annotate(
        "near singular below", (1.0, _NEAR_SINGULAR), xycoords=("axes fraction", "data"),
        xytext=(-2, 2), textcoords="offset points", ha="right", fontsize=7,
    )  # fmt: skip
    for segment in run.segments:
        if segment.name.startswith("swing"):
            for axes in (rates, angles):
                axes.axvspan(segment.start, segment.end, color=SHADE, lw=0, zorder=0)
    place_legend(rates, 2)
    return figure


def draw_strip(run: RunData) -> "Figure | None":
    """Draw the legs as sticks at the instants of the paper's photographs (Fig. 5)."""
    if not _is_walk(run):
        return None
    lengths = _lengths(run)
    duration = float(run.t[run.followed][-1])
    scale = duration / 48.0
    times = [time * scale for time in _SINGULAR_TIMES if time * scale <= duration]
    figure = new_figure(PAGE, 40.0)
    panels = figure.subplots(1, len(times), sharex=False, sharey=True)
    part = np.flatnonzero(run.followed)
    for axes, time in zip(np.atleast_1d(panels), times, strict=True):
        k = int(part[np.searchsorted(run.t[part], time).clip(max=len(part) - 1)])
        waist = _point(run, "reference.waist", k)
        for leg in _LEGS:
            foot = _point(run, f"reference.{leg}_foot", k)
            hip, knee, ankle = _sticks(waist, foot, leg, lengths)
            sticks = np.array([hip, knee, ankle]) * 1e3
            axes.plot(sticks[:, 0], sticks[:, 2], "-o", ms=2.2, color=_COLORS[leg], lw=1.3)
            heel, toe = foot[0] - lengths["back"], foot[0] + lengths["front"]
            sole = foot[2] * 1e3
            axes.plot([heel * 1e3, toe * 1e3], [sole, sole], color=_COLORS[leg], lw=2.0)
        axes.axhline(0.0, color=GREY, lw=0.5)
        axes.set_aspect("equal")
        centre = waist[0] * 1e3
        axes.set_xlim(centre - 95.0, centre + 95.0)
        axes.set_ylim(-8.0, 250.0)
        axes.set_title(f"{time:.3g} s")
        axes.tick_params(labelbottom=False)
        axes.grid(visible=False)
    np.atleast_1d(panels)[0].set_ylabel("height (mm)")
    return figure


def draw_balance(run: RunData) -> "Figure | None":
    """Draw centre of mass and zero-moment point over the footprints, and the margin."""
    if not run.has("plan.mass_x", "plan.margin"):
        return None
    figure = new_figure(PAGE, 70.0)
    ground, over_time = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
    part = run.followed
    lengths = _lengths(run)
    for leg in _LEGS:
        x, y, z = (run.log.column(f"reference.{leg}_foot_{axis}")[part] for axis in "xyz")
        prints = {(round(a, 4), round(b, 4)) for a, b, c in zip(x, y, z, strict=True) if c < 1e-6}
        for a, b in sorted(prints):
            ground.add_patch(_sole(a, b, lengths, _COLORS[leg]))
    for name, color, label in (
        ("plan.zero_moment", "#9aa5b1", "zero-moment point"),
        ("plan.mass", INK, "centre of mass"),
    ):
        a, b = (run.log.column(f"{name}_{axis}")[part] * 1e3 for axis in "xy")
        ground.plot(a, b, color=color, lw=0.9, label=label)
    ground.set_aspect("equal")
    ground.autoscale_view()
    ground.set_xlabel("x (mm)")
    ground.set_ylabel("y (mm)")
    place_legend(ground, 2)
    t = run.t[part]
    for name, color, label in (
        ("plan.margin", "#9aa5b1", "with zero-moment point"),
        ("plan.static_margin", INK, "centre of mass"),
    ):
        draw_line(over_time, t, run.log.column(name)[part] * 1e3, color, label, lw=0.9)
    finish_time_axis(over_time, t, "inside the support polygon (mm)")
    over_time.set_ylim(bottom=0.0)
    place_legend(over_time, 2)
    return figure


def draw_joints(run: RunData) -> "Figure | None":
    """Draw how far each joint is from where it was sent, and the knees' torques."""
    if not run.has("applied.position_right_knee", "reading.position_right_knee"):
        return None
    figure = new_figure(PAGE, 92.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    part = run.followed
    t = run.t[part]
    for leg in _LEGS:
        for joint in ("hip_pitch", "knee", "ankle_pitch"):
            name = f"{leg}_{joint}"
            error = np.degrees(
                run.log.column(f"applied.position_{name}")
                - run.log.column(f"reading.position_{name}")
            )[part]
            label = f"{leg} {joint.replace('_', ' ')}"
            style = {"knee": "-", "hip_pitch": (0, (4, 1.5)), "ankle_pitch": (0, (1.2, 1.2))}
            draw_line(upper, t, error, _COLORS[leg], label, lw=0.7, ls=style[joint])
        if run.has(f"truth.torque_{leg}_knee"):
            torque = run.log.column(f"truth.torque_{leg}_knee")[part]
            draw_line(lower, t, torque, _COLORS[leg], f"{leg} knee", lw=0.7)
    finish_time_axis(upper, t, "off its setpoint (deg)")
    upper.set_xlabel("")
    place_legend(upper, 3)
    finish_time_axis(lower, t, "knee torque (N m)")
    if lower.lines:
        place_legend(lower, 2)
    lower.set_xlabel(TIME_LABEL)
    return figure


def _is_walk(run: RunData) -> bool:
    return run.has("reference.right_foot_x", "command.position_right_knee") and any(
        segment.name.startswith("swing") for segment in run.segments
    )


def _lengths(run: RunData) -> dict[str, float]:
    """Return the legs' dimensions (m) from the run's own profile."""
    import yaml

    profile = yaml.safe_load((run.folder.path / "profile.yaml").read_text(encoding="utf-8"))
    geometry = profile["legs"]["geometry"]
    return {
        **{key: float(geometry[key]) for key in ("thigh", "shank", "ankle_height")},
        "spacing": float(geometry["hip_half_spacing"]),
        **{key: float(value) for key, value in geometry["sole"].items()},
    }


def _point(run: RunData, name: str, sample: int) -> tuple[float, float, float]:
    x, y, z = (float(run.log.column(f"{name}_{axis}")[sample]) for axis in "xyz")
    return x, y, z


def _sticks(
    waist: tuple[float, float, float],
    foot: tuple[float, float, float],
    leg: str,
    lengths: dict[str, float],
) -> tuple[tuple[float, float, float], ...]:
    """Return hip, knee and ankle; the knee is where thigh and shank meet, in front."""
    side = -1.0 if leg == "right" else 1.0
    hip = (waist[0], waist[1] + side * lengths["spacing"], waist[2])
    ankle = (foot[0], foot[1], foot[2] + lengths["ankle_height"])
    along = [b - a for a, b in zip(hip, ankle, strict=True)]
    distance = math.hypot(*along)
    thigh, shank = lengths["thigh"], lengths["shank"]
    share = (thigh**2 - shank**2 + distance**2) / (2.0 * distance)
    out = math.sqrt(max(thigh**2 - share**2, 0.0))
    down = [x / distance for x in along]
    # Forwards, square to the leg.
    ahead = [1.0 - down[0] ** 2, -down[0] * down[1], -down[0] * down[2]]
    size = math.hypot(*ahead)
    knee = tuple(h + share * d + out * a / size for h, d, a in zip(hip, down, ahead, strict=True))
    return hip, (knee[0], knee[1], knee[2]), ankle


def _sole(x: float, y: float, lengths: dict[str, float], color: str) -> Any:
    from matplotlib.patches import Rectangle

    width = 2e3 * lengths["half_width"]
    return Rectangle(
        ((x - lengths["back"]) * 1e3, y * 1e3 - 0.5 * width),
        (lengths["front"] + lengths["back"]) * 1e3,
        width,
        facecolor="none",
        edgecolor=color,
        lw=0.8,
    )


LEGS_FIGURES = {
    "ankle": FigureKind(draw_ankle, "Path of one sole, knee angle and knee rate in a swing."),
    "knees": FigureKind(draw_knees, "Rates and angles of both knees; swings are shaded."),
    "strip": FigureKind(draw_strip, "The legs from the side; right leg orange, left leg blue."),
    "balance": FigureKind(
        draw_balance, "Centre of mass and zero-moment point over the footprints, and the margin."
    ),
    "joints": FigureKind(draw_joints, "Servo errors of the pitch joints, and the knees' torques."),
}
