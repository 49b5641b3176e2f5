"""Footprints from above: planned, measured, and what is above them; and all joints' rates."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rig.mechanisms.legs.figures.base import (
    COLORS,
    LEGS,
    is_walk,
    landings,
    mark_phases,
    sole_outline,
)
from rig.mechanisms.legs.measures import from_first_stance
from rig.report.data import RunData
from rig.report.envelope import path_envelope
from rig.report.figure import TIME_LABEL, FigureKind, draw_line, finish_time_axis, panels
from rig.report.style import INK, PAGE, new_figure, place_legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_APART = 14.0
"""Of two numbers of prints, mm."""
_AROUND = 25.0
"""Beside the outermost prints, mm."""
_PALE = "#b4bdc7"
_ROWS = (
    ("hip_yaw", "hip_roll", "ankle_roll"),
    ("hip_pitch", "knee", "ankle_pitch"),
)


def draw_footsteps(run: RunData) -> "Figure | None":
    """Draw the planned footprints from above, where the feet came down, and their way there."""
    if not is_walk(run) or not run.has("reference.right_foot_yaw"):
        return None
    from matplotlib.colors import to_rgba

    figure = new_figure(PAGE, 92.0)
    (ground,) = panels(figure, 1, 1)
    planned = _feet(run, "reference")
    measured = _feet(run, "truth") if run.has("truth.right_foot_x") else None
    landed = landings(run)
    taken: list[Array] = []
    for number, leg in enumerate(LEGS):
        way = planned[:, number] * 1e3
        ground.plot(*path_envelope(way[:, 0], way[:, 1]), color=COLORS[leg], lw=0.6, ls=(0, (1, 2)))
        for count, sample in landed[leg]:
            corners = sole_outline(run, leg, sample) * 1e3
            ground.fill(*corners.T, fc=to_rgba(COLORS[leg], 0.07), ec=COLORS[leg], lw=0.8)
            if count:
                at = _place_of_number(corners, taken)
                taken.append(at)
                ground.annotate(
                    str(count),
                    tuple(at.tolist()),
                    fontsize=7,
                    ha="center",
                    va="center",
                    color=COLORS[leg],
                )
    for name, color, width, label in (
        ("plan.zero_moment", _PALE, 2.4, "zero-moment point, planned"),
        ("plan.mass", INK, 0.9, "centre of mass, planned"),
    ):
        ground.plot(
            *(run.trace(f"{name}_{axis}") * 1e3 for axis in "xy"),
            color=color,
            lw=width,
            label=label,
        )
    if measured is not None:
        _draw_measured(ground, measured, landed)
    ground.set_aspect("equal")
    soles = np.concatenate(
        [sole_outline(run, leg, sample) * 1e3 for leg in LEGS for _, sample in landed[leg]]
    )
    # What lies elsewhere, as the feet of a robot that fell, does not set the scale.
    for limits, along in ((ground.set_xlim, soles[:, 0]), (ground.set_ylim, soles[:, 1])):
        limits(along.min() - _AROUND, along.max() + _AROUND)
    ground.set_xlabel("ahead (mm)")
    ground.set_ylabel("to the left (mm)")
    place_legend(ground, 2)
    return figure


def _draw_measured(ground: "Axes", feet: "Array", landed: dict[str, list[tuple[int, int]]]) -> None:
    """Mark where the ankles came down."""
    for number, leg in enumerate(LEGS):
        samples = [sample for _, sample in landed[leg]]
        at = feet[samples, number] * 1e3
        ground.plot(
            at[:, 0], at[:, 1], "+", ms=6.0, mew=1.1, color=COLORS[leg],
            label=f"{leg} ankle, measured",
        )  # fmt: skip


def _place_of_number(corners: "Array", taken: Sequence["Array"]) -> "Array":
    """Return where a print's number has room, mm: inside the toes, the heel, or between."""
    toes, heel = 0.5 * (corners[0] + corners[1]), 0.5 * (corners[2] + corners[3])
    places = [toes + share * (heel - toes) for share in (0.1, 0.9, 0.3, 0.7)]
    for at in places:
        if all(np.linalg.norm(at - other) > _APART for other in taken):
            return np.asarray(at)
    return np.asarray(places[0])


def draw_rates(run: RunData) -> "Figure | None":
    """Draw the rates of all joints against their limit."""
    if not run.has("command.velocity_right_knee", "command.velocity_left_ankle_roll"):
        return None
    limit = float(run.settings["geometry"]["max_rate"])
    figure = new_figure(PAGE, 92.0)
    strips = panels(figure, 3, 2, sharex=True)
    t = run.time
    has_limits = False
    for column, joints in enumerate(_ROWS):
        for row, joint in enumerate(joints):
            axes: Axes = strips[2 * row + column]
            most = 0.0
            for leg in LEGS:
                rate = run.trace(f"command.velocity_{leg}_{joint}")
                most = max(most, float(np.max(np.abs(rate))))
                draw_line(axes, t, rate, COLORS[leg], f"{leg} leg", lw=0.7)
            finish_time_axis(axes, t, f"{joint.replace('_', ' ')}\n(rad/s)", "")
            mark_phases(axes, run)
            axes.set_title(
                f"at most {most:.3g} of {limit:g} rad/s", loc="left", pad=2.0, fontsize=7
            )
            if most > 0.5 * limit:
                for bound in (-limit, limit):
                    axes.axhline(bound, color=INK, lw=0.8, ls=(0, (4, 2)))
                has_limits = True
    if has_limits:
        strips[0].plot([], [], color=INK, lw=0.8, ls=(0, (4, 2)), label="limit")
    place_legend(strips[0], 3)
    for axes in strips[-2:]:
        axes.set_xlabel(TIME_LABEL)
    figure.align_ylabels()
    return figure


def _feet(run: RunData, source: str) -> "Array":
    """Return both feet as they are seen from where they stood at first, shape (n, 2, 3), m."""
    return from_first_stance(np.stack([run.track(f"{source}.{leg}_foot") for leg in LEGS], axis=1))


FOOTSTEP_FIGURES = {
    "footsteps": FigureKind(
        draw_footsteps,
        "The planned footprints from above with their numbers, crosses where the ankles came "
        "down, and the planned centre of mass and zero-moment point.",
    ),
    "joint-rates": FigureKind(
        draw_rates, "Rates of all joints of both legs; their limit where they come near it."
    ),
}
