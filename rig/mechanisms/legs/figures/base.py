"""What the figures of the legs have in common."""

from typing import TYPE_CHECKING

import numpy as np

from rig.report.data import RunData
from rig.report.style import BLUE, SHADE, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LEGS = ("right", "left")
COLORS = {"right": VERMILION, "left": BLUE}
_MOST_TICKS = 16


def is_walk(run: RunData) -> bool:
    """Return whether a run is one of legs in which a foot swings."""
    return run.has("reference.right_foot_x", "command.position_right_knee") and any(
        segment.name.startswith("swing") for segment in run.segments
    )


def turns(run: RunData) -> bool:
    """Return whether the waist or a sole turns in a run: sticks from the side then mean nothing."""
    names = ["reference.waist_yaw", *(f"reference.{leg}_foot_yaw" for leg in LEGS)]
    return any(run.has(name) and bool(np.any(run.trace(name))) for name in names)


_LAST = 0.1
"""The last sample of a run comes by less before its end, s."""


def mark_phases(axes: "Axes", run: RunData, most: int = _MOST_TICKS) -> None:
    """Shade the swings, and tick the instants between phases: there the knees are straight.

    Parameters
    ----------
    axes : Axes
        Of a signal over time.
    run : RunData
        Whose phases.
    most : int
        More instants than these are not ticked: their numbers would run into each other.
    """
    end = float(run.time[-1]) + _LAST  # a run that ended early did not come to what was planned
    phases = [s for s in run.segments if s.name != "all" and s.start < end]
    for phase in phases:
        if phase.name.startswith("swing"):
            axes.axvspan(
                phase.start, min(phase.end, float(run.time[-1])), color=SHADE, lw=0, zorder=0
            )
    ends = [phase.end if phase.end <= end else float(run.time[-1]) for phase in phases]
    instants = sorted({0.0, *ends})
    if len(phases) > 1 and len(instants) <= most:
        axes.set_xticks(instants, labels=[f"{instant:.3g}" for instant in instants])


def landings(run: RunData) -> dict[str, list[tuple[int, int]]]:
    """Return number and sample of each footprint of either foot; number 0 is the start.

    A run that ended early has those only that it came to.
    """
    landed: dict[str, list[tuple[int, int]]] = {leg: [(0, 0)] for leg in LEGS}
    for segment in run.segments:
        kind, *rest = segment.name.split()
        if kind == "swing" and segment.end <= run.time[-1] + _LAST:
            sample = int(np.searchsorted(run.time, segment.end - 1e-9).clip(max=len(run.time) - 1))
            landed[rest[0]].append((int(rest[1]), sample))
    return landed


def sole_outline(run: RunData, leg: str, sample: int) -> "Array":
    """Return the corners of a planned sole from above, the toes first, shape (4, 2), m."""
    sole = {key: float(value) for key, value in run.settings["geometry"]["sole"].items()}
    front, back, half = sole["front"], -sole["back"], sole["half_width"]
    at = np.array(((front, half), (front, -half), (back, -half), (back, half)))
    name = f"reference.{leg}_foot_yaw"
    yaw = float(run.trace(name)[sample]) if run.has(name) else 0.0
    s, c = np.sin(yaw), np.cos(yaw)
    place = run.track(f"reference.{leg}_foot")[sample, :2]
    return np.asarray(at @ np.array(((c, s), (-s, c))) + place, dtype=np.float64)
