"""What the legs feel: where their feet are pressed beside the plan, and how the waist leans."""

from typing import TYPE_CHECKING

import numpy as np

from rig.mechanisms.legs.figures.base import mark_phases
from rig.report.data import RunData
from rig.report.figure import FigureKind, draw_line, finish_time_axis, panels
from rig.report.style import INK, PAGE, new_figure, place_legend

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PALE = "#b4bdc7"
_SIDES = {"roll": "#2f6f9f", "pitch": "#b5542c"}


def draw_sway(run: RunData) -> "Figure | None":
    """Draw the feet's pressure beside the planned zero-moment point, and the waist's lean."""
    if not run.has("balance.pressure_x", "reading.waist_roll"):
        return None
    figure = new_figure(PAGE, 92.0)
    *places, leans = panels(figure, 3, 1, sharex=True)
    t = run.time
    for axes, axis, way in zip(places, "xy", ("ahead", "to the left"), strict=True):
        for name, color, width, label in (
            (f"balance.pressure_{axis}", _PALE, 0.8, "felt"),
            (f"plan.zero_moment_{axis}", INK, 0.9, "planned"),
        ):
            draw_line(axes, t, run.trace(name) * 1e3, color, label, lw=width)
        finish_time_axis(axes, t, f"pressure\n{way} (mm)", "")
    for lean, color in _SIDES.items():
        draw_line(leans, t, np.degrees(run.trace(f"reading.waist_{lean}")), color, lean, lw=0.8)
    finish_time_axis(leans, t, "lean (deg)")
    for axes in (*places, leans):
        mark_phases(axes, run)
    place_legend(places[0], 2)
    place_legend(leans, 2)
    return figure


SWAY_FIGURES = {
    "sway": FigureKind(
        draw_sway,
        "Where the feet are pressed beside the planned zero-moment point, and the waist's lean.",
    )
}
