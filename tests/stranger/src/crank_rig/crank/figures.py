"""The crank's figure, and how its runs are compared."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rig.report.comparison import Comparison, color_of
from rig.report.data import RunData
from rig.report.figure import FigureKind, draw_line, finish_time_axis
from rig.report.style import PAGE, new_figure, place_legend, shade_segments

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TWIST = "reading.twist"


def draw_twist(run: RunData) -> "Figure | None":
    """Draw the rod's twist over time; nothing of a log without it."""
    return _draw([run], ["twist"]) if run.has(_TWIST) else None


def draw_twists(runs: Sequence[RunData], labels: Sequence[str]) -> "Figure":
    """Draw the rod's twist in several runs."""
    return _draw(runs, labels)


def _draw(runs: Sequence[RunData], labels: Sequence[str]) -> "Figure":
    figure = new_figure(PAGE, 60.0)
    axes = figure.add_subplot()
    for number, (run, label) in enumerate(zip(runs, labels, strict=True)):
        part = run.followed
        twist = run.log.column(_TWIST)[part] * 1e3
        draw_line(axes, run.t[part], twist, color_of(number), label, lw=0.8)
    finish_time_axis(axes, runs[0].t[runs[0].followed], "twist of the rod (mrad)")
    shade_segments(axes, PAGE, runs[0].segments)
    place_legend(axes, len(runs))
    return figure


CRANK_FIGURES = {"twist": FigureKind(draw_twist, "Twist of the rod; the turns are shaded.")}
CRANK_COMPARISON = Comparison(lambda run: run.has(_TWIST), draw_twists)
