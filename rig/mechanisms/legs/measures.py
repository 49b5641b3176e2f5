"""Numbers that say how the legs walked: what became of the plan on the robot.

What only a simulation knows (whether it fell, the torques) is taken from the plant.
"""

from typing import TYPE_CHECKING

import numpy as np

from rig.experiment.measure import Measure, Window, Windows, pooled, rms

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

KNEES = ("right_knee", "left_knee")


def fell(windows: Windows) -> float:
    """Return 1 if the robot fell, else 0."""
    return max(float(window.column("truth.fell").max()) for window in windows)


def advance_measured(windows: Windows) -> float:
    """Return how far the waist went ahead, m."""
    return sum(
        float(advance[-1] - advance[0])
        for advance in (window.column("truth.advance") for window in windows)
    )


def slip_max(windows: Windows) -> float:
    """Return how far the worse foot slipped off its prints, m."""
    return max(float(window.columns("truth.slip_").max()) for window in windows)


def knee_torque_max(windows: Windows) -> float:
    """Return the greatest torque of either knee, N m."""
    return max(
        float(np.abs(window.column(f"truth.torque_{knee}")).max())
        for window in windows
        for knee in KNEES
    )


def knee_torque_mean(windows: Windows) -> float:
    """Return the mean torque of the knee that bears more, N m: what straight knees save."""

    def bearing(window: Window) -> "Array":
        torques = np.abs(np.column_stack([window.column(f"truth.torque_{k}") for k in KNEES]))
        right, left = window.column("truth.load_right"), window.column("truth.load_left")
        torque: Array = np.where(right > left, torques[:, 0], torques[:, 1])
        return torque

    return float(pooled(windows, bearing).mean())


def saturated_share(windows: Windows) -> float:
    """Return the share of the time in which a servo is at its torque or its speed."""
    return float((pooled(windows, lambda window: window.column("truth.saturated")) > 0.5).mean())


def knee_rate_measured(windows: Windows) -> float:
    """Return the greatest rate of either knee as its servo says, rad/s."""
    return max(
        float(np.abs(window.column(f"reading.velocity_{knee}")).max())
        for window in windows
        for knee in KNEES
    )


def following_rms(windows: Windows) -> float:
    """Return the rms distance of all joints from where they were sent, rad."""

    def error(window: Window) -> "Array":
        difference: Array = window.columns("applied.position_") - window.columns(
            "reading.position_"
        )
        return difference.ravel()

    return rms(pooled(windows, error))


LEGS_MEASURES: dict[str, Measure] = {
    "fell": Measure(fell, "", "1 if the robot fell"),
    "advance_measured": Measure(advance_measured, "m", "how far the waist went ahead"),
    "slip_max": Measure(slip_max, "m", "how far the worse foot slipped"),
    "knee_torque_max": Measure(knee_torque_max, "N m", "greatest torque of either knee"),
    "knee_torque_mean": Measure(knee_torque_mean, "N m", "mean torque of the bearing knee"),
    "saturated_share": Measure(saturated_share, "", "share of the time with a servo at its limit"),
    "knee_rate_measured": Measure(knee_rate_measured, "rad/s", "greatest measured knee rate"),
    "following_rms": Measure(
        following_rms, "rad", "rms distance of the joints from their setpoints"
    ),
}
