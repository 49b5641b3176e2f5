"""What the figures of the legs have in common."""

from typing import TYPE_CHECKING

from rig.report.data import RunData
from rig.report.style import BLUE, SHADE, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEGS = ("right", "left")
COLORS = {"right": VERMILION, "left": BLUE}
_MOST_TICKS = 16


def is_walk(run: RunData) -> bool:
    """Return whether a run is one of legs in which a foot swings."""
    return run.has("reference.right_foot_x", "command.position_right_knee") and any(
        segment.name.startswith("swing") for segment in run.segments
    )


def mark_phases(axes: "Axes", run: RunData) -> None:
    """Shade the swings, and tick the instants between phases: there the knees are straight."""
    phases = [segment for segment in run.segments if segment.name != "all"]
    for phase in phases:
        if phase.name.startswith("swing"):
            axes.axvspan(phase.start, phase.end, color=SHADE, lw=0, zorder=0)
    instants = sorted({0.0, *(phase.end for phase in phases)})
    if len(phases) > 1 and len(instants) <= _MOST_TICKS:
        axes.set_xticks(instants, labels=[f"{instant:.3g}" for instant in instants])
