"""Numbers that say how the legs walked: what became of the plan on the robot.

What only a simulation knows (whether it fell, the torques) is taken from the plant.
"""

from typing import TYPE_CHECKING

import numpy as np

from rig.experiment.measure import (
    Measure,
    Values,
    Window,
    Windows,
    column,
    columns,
    greatest,
    pooled,
    rms_of,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

KNEES = ("right_knee", "left_knee")


def advance_measured(windows: Windows) -> float:
    """Return how far the waist went ahead, m."""
    return sum(
        float(advance[-1] - advance[0])
        for advance in (window.column("truth.advance") for window in windows)
    )


def knee_torque_mean(windows: Windows) -> float:
    """Return the mean torque of the knee that bears more, N m: what straight knees save."""

    def bearing(window: Window) -> "Array":
        torques = np.abs(_knees("truth.torque")(window))
        right, left = window.column("truth.load_right"), window.column("truth.load_left")
        torque: Array = np.where(right > left, torques[:, 0], torques[:, 1])
        return torque

    return float(pooled(windows, bearing).mean())


def saturated_share(windows: Windows) -> float:
    """Return the share of the time in which a servo is at its torque or its speed."""
    return float((pooled(windows, lambda window: window.column("truth.saturated")) > 0.5).mean())


def _knees(prefix: str) -> Values:
    """Return what takes a column of both knees."""
    return lambda window: np.column_stack([window.column(f"{prefix}_{knee}") for knee in KNEES])


def _following_error(window: Window) -> "Array":
    """Return how far each joint is from where it was sent, rad, shape (12 n,)."""
    error = window.columns("applied.position_") - window.columns("reading.position_")
    return error.ravel()


LEGS_MEASURES: dict[str, Measure] = {
    "fell": Measure(greatest(column("truth.fell")), "", "1 if the robot fell"),
    "advance_measured": Measure(advance_measured, "m", "how far the waist went ahead"),
    "slip_max": Measure(greatest(columns("truth.slip_")), "m", "how far the worse foot slipped"),
    "knee_torque_max": Measure(
        greatest(_knees("truth.torque")), "N m", "greatest torque of either knee"
    ),
    "knee_torque_mean": Measure(knee_torque_mean, "N m", "mean torque of the bearing knee"),
    "saturated_share": Measure(saturated_share, "", "share of the time with a servo at its limit"),
    "knee_rate_measured": Measure(
        greatest(_knees("reading.velocity")), "rad/s", "greatest measured knee rate"
    ),
    "following_rms": Measure(
        rms_of(_following_error), "rad", "rms distance of the joints from their setpoints"
    ),
}
