"""Numbers that say what became of an arm's planned motion on the arm.

Where the arm is simulated, the hand is where it truly was; on a rig, where the measured joints
put it.
"""

from typing import TYPE_CHECKING

import numpy as np

from rig.experiment.measures.base import Measure, Window, Windows, pooled, rms

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_NEAR = 400
"""Cycles before and after a sample in which its nearest place on the path is looked for."""


def off_path(window: Window) -> "Array":
    """Return the distance of the hand from the planned path, whenever it got there, m."""
    source = "truth" if window.has("truth.hand_x") else "reading"
    hand, path = window.columns(f"{source}.hand_"), window.columns("reference.hand_")
    distances = np.empty(len(hand))
    for k, point in enumerate(hand):
        near = path[max(k - _NEAR, 0) : k + _NEAR]
        distances[k] = _to_polyline(point, near)
    return distances


def path_deviation_measured(windows: Windows) -> float:
    """Return the greatest distance of the hand from the planned path, m."""
    return max(float(off_path(window).max()) for window in windows)


def hand_lag(windows: Windows) -> float:
    """Return the rms distance of the hand from where it should be at the time, m."""

    def error(window: Window) -> "Array":
        source = "truth" if window.has("truth.hand_x") else "reading"
        difference: Array = window.columns(f"{source}.hand_") - window.columns("reference.hand_")
        return difference

    return rms(np.linalg.norm(pooled(windows, error), axis=1))


def peak_rate_measured(windows: Windows) -> float:
    """Return the greatest rate of any joint as its drive says, rad/s."""
    return max(float(np.abs(window.columns("reading.velocity_q")).max()) for window in windows)


def torque_max(windows: Windows) -> float:
    """Return the greatest torque of any joint, N m; only a simulation knows it."""
    return max(float(np.abs(window.columns("truth.torque_q")).max()) for window in windows)


ARM_MEASURES: dict[str, Measure] = {
    "path_deviation_measured": Measure(
        path_deviation_measured, "m", "greatest distance of the hand from the planned path"
    ),
    "hand_lag": Measure(hand_lag, "m", "rms distance of the hand from its place at the time"),
    "peak_rate_measured": Measure(peak_rate_measured, "rad/s", "greatest measured joint rate"),
    "torque_max": Measure(torque_max, "N m", "greatest joint torque"),
}


def _to_polyline(point: "Array", path: "Array") -> float:
    """Return the distance of a point from the line through some points, m."""
    starts, ways = path[:-1], np.diff(path, axis=0)
    squares = np.einsum("ij,ij->i", ways, ways)
    along = np.einsum("ij,ij->i", point - starts, ways)
    shares = np.clip(np.divide(along, squares, out=np.zeros_like(along), where=squares > 0.0), 0, 1)
    feet = starts + shares[:, None] * ways
    return float(np.sqrt(((point - feet) ** 2).sum(axis=1).min()))
