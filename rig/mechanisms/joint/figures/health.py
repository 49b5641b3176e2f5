"""What speaks against the joint being whole: wires that disagree, a ring that twists."""

from typing import TYPE_CHECKING

import numpy as np

from rig.report.data import RunData
from rig.report.figure import TIME_LABEL, FigureKind, draw_line, finish_time_axis
from rig.report.style import BLUE, PAGE, VERMILION, new_figure, place_legend

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_health(run: RunData) -> "Figure | None":
    """Draw how far the wires are from agreeing on a pose, and the ring's twist about its axis."""
    if not run.has("estimate.residual", "reading.twist"):
        return None
    t, seen = run.time, np.degrees(run.trace("reading.twist"))
    twists = [(seen, BLUE, "seen by the camera")] if np.any(seen) else []
    if run.has("truth.twist"):
        twists.insert(0, (np.degrees(run.trace("truth.twist")), VERMILION, "true"))
    figure = new_figure(PAGE, 40.0 if not twists else 72.0)
    panels = figure.subplots(2 if twists else 1, 1, sharex=True, squeeze=False)[:, 0]
    draw_line(panels[0], t, run.trace("estimate.residual") * 1e6, BLUE, "residual", lw=0.8)
    finish_time_axis(panels[0], t, "wires disagree (µm)")
    panels[0].set_ylim(bottom=0.0)
    if twists:
        for values, color, label in twists:
            draw_line(panels[1], t, values, color, label, lw=0.8)
        panels[0].set_xlabel("")
        finish_time_axis(panels[1], t, "twist (°)")
        place_legend(panels[1], 2)
    panels[-1].set_xlabel(TIME_LABEL)
    return figure


HEALTH_FIGURES = {
    "joint-health": FigureKind(
        draw_health,
        "How far the four wires are from agreeing on a pose, and how far the ring is turned about "
        "its own axis: only a marker that shows it (ArUco) lets the camera see that.",
    ),
}
