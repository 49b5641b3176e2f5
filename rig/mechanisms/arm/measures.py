"""Numbers that say what became of an arm's planned motion on the arm.

Where the arm is simulated, the hand is where it truly was; on a rig, where the measured joints
put it.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from rig.experiment.measure import (
    Measure,
    Window,
    Windows,
    column,
    columns,
    greatest,
    lengths,
    rms_of,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_NEAR = 400
"""Cycles before and after a sample in which its nearest place on the path is looked for."""
_JOINTS = ("q1", "q2", "q3", "q4", "q5", "q6")
_ARRIVED = 0.2e-3
"""A hand that stays so near to the end of its path has arrived, m."""


def off_path(window: Window) -> "Array":
    """Return the distance of the hand from the path as far as it is gone, whenever, m."""
    hand, path = window.columns(f"{_source(window)}.hand_"), window.columns("plan.path_")
    distances = np.empty_like(hand, shape=len(hand))
    for k, point in enumerate(hand):
        near = path[max(k - _NEAR, 0) : k + _NEAR]
        distances[k] = _to_polyline(point, near)
    return distances


def time_crossing_measured(windows: Windows) -> float:
    """Return when the elbow first goes through its singularity by readings of that time, s.

    Infinite if it never does.
    """
    instants = [
        _zeros(window.t - window.column("reading.age"), window.column("reading.index_elbow"))
        for window in windows
    ]
    return min((float(found[0]) for found in instants if len(found)), default=math.inf)


def elbow_sign_changes_measured(windows: Windows) -> float:
    """Return how often the measured elbow goes through its singularity."""
    return float(
        sum(len(_zeros(window.t, window.column("reading.index_elbow"))) for window in windows)
    )


def time_end_measured(windows: Windows) -> float:
    """Return when the hand has come to the end of its path and stays there, s.

    Infinite if it is not there when the run ends.
    """
    window = windows[-1]
    hand, end = window.columns(f"{_source(window)}.hand_"), window.columns("reference.hand_")[-1]
    away = np.flatnonzero(np.linalg.norm(hand - end, axis=1) > _ARRIVED)
    if not len(away):
        return float(window.t[0])
    return float(window.t[away[-1] + 1]) if away[-1] + 1 < len(hand) else math.inf


def dwell_time_measured(windows: Windows) -> float:
    """Return how long the measured elbow is within the region, of all segments, s.

    The region's border is where the planned elbow is when the segment ``region`` begins; of a
    law that has no region the time is infinite.
    """
    named = {window.segment.name: window for window in windows}
    if "region" not in named or "all" not in named:
        return math.inf
    whole, t = named["all"], named["all"].t
    planned = np.abs(whole.column("plan.index_elbow"))
    border = float(np.interp(named["region"].segment.start, t, planned))
    beyond = np.abs(whole.column("reading.index_elbow")) - border
    instants = _zeros(t, beyond)
    return float(instants[-1] - instants[0]) if len(instants) > 1 else math.inf


def _twist_residual(window: Window) -> "Array":
    """Return ``J q' - (b v, b^2 w)`` of measured joints and rates, shape (n, 6).

    The drives come later than planned, which is most of it where b changes.
    """
    scales = [f"plan.scale{of}" for of in ("", "_turn") for _ in "xyz"]
    asked = window.columns("plan.asked_") * np.column_stack(list(map(window.column, scales)))
    return window.columns("reading.twist_") - asked


def _hand_distance(window: Window) -> "Array":
    """Return the hand's distance from where it should be at the time, m, shape (n,)."""
    hand = window.columns(f"{_source(window)}.hand_")
    return lengths(hand - window.columns("reference.hand_"))


def return_error_measured(windows: Windows) -> float:
    """Return by how much the measured joints end elsewhere than they began, whole turns apart."""
    first, last = (windows[k].columns("reading.position_q")[k] for k in (0, -1))
    difference = last - first
    turns = 2.0 * math.pi * np.round(difference / (2.0 * math.pi))
    return float(np.abs(difference - turns).max())


ARM_MEASURES: dict[str, Measure] = {
    "path_deviation_measured": Measure(
        greatest(off_path), "m", "greatest distance of the hand from the path"
    ),
    "hand_lag": Measure(
        rms_of(_hand_distance), "m", "rms distance of the hand from its place at the time"
    ),
    "time_crossing_measured": Measure(
        time_crossing_measured, "s", "first pass of the measured elbow through its singularity"
    ),
    "time_end_measured": Measure(
        time_end_measured, "s", "from when on the hand stays within 0.2 mm of its path's end"
    ),
    "elbow_sign_changes_measured": Measure(
        elbow_sign_changes_measured, "", "passes of the measured elbow through its singularity"
    ),
    "dwell_time_measured": Measure(
        dwell_time_measured, "s", "time of the measured elbow in the singular region"
    ),
    "twist_residual_measured": Measure(
        greatest(_twist_residual), "", "greatest entry of J q' - (b v, b² w), measured"
    ),
    "return_error_measured": Measure(
        return_error_measured, "rad", "measured joints at the end from those at the start"
    ),
    "peak_rate_measured": Measure(
        greatest(columns("reading.velocity_q")), "rad/s", "greatest measured joint rate"
    ),
    **{
        f"peak_rate_{joint}_measured": Measure(
            greatest(column(f"reading.velocity_{joint}")),
            "rad/s",
            f"greatest measured rate of {joint}",
        )
        for joint in _JOINTS
    },
    "torque_max": Measure(greatest(columns("truth.torque_q")), "N m", "greatest joint torque"),
}


def _source(window: Window) -> str:
    """Return where the hand is taken from: the truth where it is known."""
    return "truth" if window.has("truth.hand_x") else "reading"


def _zeros(t: "Array", x: "Array") -> "Array":
    """Return when a signal changes its sign, on straight lines between the samples, s."""
    k = np.flatnonzero(x[:-1] * x[1:] < 0.0)
    instants: Array = t[k] + (t[k + 1] - t[k]) * x[k] / (x[k] - x[k + 1])
    return instants


def _to_polyline(point: "Array", path: "Array") -> float:
    """Return the distance of a point from the line through some points, m."""
    starts, ways = path[:-1], np.diff(path, axis=0)
    squares = np.einsum("ij,ij->i", ways, ways)
    along = np.einsum("ij,ij->i", point - starts, ways)
    shares = np.clip(np.divide(along, squares, out=np.zeros_like(along), where=squares > 0.0), 0, 1)
    feet = starts + shares[:, None] * ways
    return float(np.sqrt(((point - feet) ** 2).sum(axis=1).min()))
