"""How walking legs stand: sticks from the side, and what is above the footprints."""

import math
from typing import TYPE_CHECKING

import numpy as np

from rig.mechanisms.legs.figures.base import (
    COLORS,
    LEGS,
    is_walk,
    landings,
    mark_phases,
    sole_outline,
    turns,
)
from rig.report.data import RunData
from rig.report.envelope import path_envelope
from rig.report.figure import FigureKind, draw_line, finish_time_axis, panels
from rig.report.style import GREY, INK, PAGE, new_figure, place_legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    Point = tuple[float, float, float]

_PHOTOGRAPHS = (18.0, 20.0, 22.0, 24.0, 27.0, 29.0, 31.0, 33.0)
"""s of 48 s; when the photographs of the paper's Fig. 5 were taken."""
_PAPER_WALK = 48.0
_NEARLY_STRAIGHT = math.radians(5.0)
_PALE = "#b4bdc7"


def draw_strip(run: RunData) -> "Figure | None":
    """Draw the legs from the side at the instants of the paper's photographs (Fig. 5)."""
    if not is_walk(run) or turns(run):
        return None
    lengths = _lengths(run)
    t = run.time
    scale = min(float(t[-1]) / _PAPER_WALK, 1.0)
    times = [time * scale for time in _PHOTOGRAPHS if time * scale <= t[-1]]
    figure = new_figure(PAGE, 37.0)
    strip = panels(figure, 1, len(times), sharey=True)
    for number, (axes, time) in enumerate(zip(strip, times, strict=True)):
        sample = int(np.searchsorted(t, time).clip(max=len(t) - 1))
        _draw_sticks(axes, run, sample, lengths)
        axes.set_title(f"({'abcdefgh'[number]}) {time:.3g} s")
    strip[0].set_ylabel("height (mm)")
    return figure


def draw_balance(run: RunData) -> "Figure | None":
    """Draw centre of mass and zero-moment point over the footprints, and the margin."""
    if not run.has("plan.mass_x", "plan.margin"):
        return None
    from matplotlib.colors import to_rgba

    figure = new_figure(PAGE, 72.0)
    ground, over_time = panels(figure, 1, 2, width_ratios=[1.15, 1.0])
    for leg, prints in landings(run).items():
        for number, (_, sample) in enumerate(prints):
            corners = sole_outline(run, leg, sample) * 1e3
            ground.fill(
                *corners.T, fc=to_rgba(COLORS[leg], 0.07), ec=COLORS[leg], lw=0.8,
                label="_" if number else f"{leg} foot",
            )  # fmt: skip
    for name, color, width, label in (
        ("plan.zero_moment", _PALE, 2.4, "zero-moment point"),
        ("plan.mass", INK, 0.9, "centre of mass"),
    ):
        a, b = (run.trace(f"{name}_{axis}") * 1e3 for axis in "xy")
        ground.plot(*path_envelope(a, b), color=color, lw=width, label=label)
        if name == "plan.mass":
            ground.plot(a[0], b[0], "o", ms=3.0, color=INK, ls="", label="start")
            ground.plot(a[-1], b[-1], "s", ms=3.0, color=INK, ls="", label="end")
    ground.set_aspect("equal")
    ground.autoscale_view()
    ground.set_xlabel("x (mm)")
    ground.set_ylabel("y (mm)")
    place_legend(ground, 3)
    t = run.time
    for name, color, width, label in (
        ("plan.margin", _PALE, 2.4, "with zero-moment point"),
        ("plan.static_margin", INK, 0.9, "centre of mass"),
    ):
        draw_line(over_time, t, run.trace(name) * 1e3, color, label, lw=width)
    bound = run.settings["balance"]["min_margin"] * 1e3
    over_time.axhline(bound, color=INK, lw=0.8, ls=(0, (4, 2)))
    over_time.annotate(
        "refused below", (1.0, bound), xycoords=("axes fraction", "data"), xytext=(-2, 2),
        textcoords="offset points", ha="right", fontsize=7,
    )  # fmt: skip
    finish_time_axis(over_time, t, "inside the edge of the support (mm)")
    over_time.set_ylim(bottom=0.0)
    mark_phases(over_time, run)
    place_legend(over_time, 2)
    return figure


def _draw_sticks(axes: "Axes", run: RunData, sample: int, lengths: dict[str, float]) -> None:
    waist = _point(run, "reference.waist", sample)
    axes.axhline(0.0, color=GREY, lw=0.5)
    x, top = waist[0] * 1e3, waist[2] * 1e3
    axes.plot([x, x], [top, top + 28.0], color=INK, lw=3.0, solid_capstyle="round")
    for leg in LEGS:
        color = COLORS[leg]
        foot = _point(run, f"reference.{leg}_foot", sample)
        joints = np.array(_sticks(waist, foot, leg, lengths)) * 1e3
        along, up = joints[:, 0], joints[:, 2]
        axes.plot(along, up, "-o", ms=2.2, color=color, lw=1.3)
        sole = foot[2] * 1e3
        axes.plot([along[2], foot[0] * 1e3], [up[2], sole], color=color, lw=1.3)
        heel, toe = foot[0] - lengths["back"], foot[0] + lengths["front"]
        axes.plot([heel * 1e3, toe * 1e3], [sole, sole], color=color, lw=2.0)
        if run.trace(f"command.position_{leg}_knee")[sample] < _NEARLY_STRAIGHT:
            axes.plot(along[1], up[1], "o", ms=6.5, mfc="none", mec=color, mew=0.7)
    axes.set_aspect("equal")
    axes.set_xlim(x - 84.0, x + 84.0)
    axes.set_ylim(-8.0, 270.0)
    axes.set_xticks([])
    axes.spines["bottom"].set_visible(False)
    axes.grid(visible=False)


def _lengths(run: RunData) -> dict[str, float]:
    """Return the legs' dimensions, m."""
    geometry = run.settings["geometry"]
    return {
        **{key: float(geometry[key]) for key in ("thigh", "shank", "ankle_height")},
        "spacing": float(geometry["hip_half_spacing"]),
        **{key: float(value) for key, value in geometry["sole"].items()},
    }


def _point(run: RunData, name: str, sample: int) -> "Point":
    x, y, z = run.track(name)[sample].tolist()
    return x, y, z


def _sticks(
    waist: "Point", foot: "Point", leg: str, lengths: dict[str, float]
) -> "tuple[Point, Point, Point]":
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
    knee = [h + share * d + out * a / size for h, d, a in zip(hip, down, ahead, strict=True)]
    return hip, (knee[0], knee[1], knee[2]), ankle


STANCE_FIGURES = {
    "strip": FigureKind(
        draw_strip,
        "The legs from the side, right leg orange, left leg blue; a circle marks a nearly "
        "straight knee.",
    ),
    "balance": FigureKind(
        draw_balance,
        "Centre of mass and zero-moment point over the footprints, from the dot to the square, "
        "and how far inside the edge of the support they are.",
    ),
}
