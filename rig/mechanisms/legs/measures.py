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


def feet_astray_end(windows: Windows) -> float:
    """Return how far the worse foot in the end is from where it was planned, m.

    Seen from both feet at the start: where the robot stood ready is no part of its walk.
    """
    window = windows[-1]

    def feet(source: str) -> "Array":
        tracks = [
            np.column_stack([window.column(f"{source}.{leg}_foot_{axis}") for axis in "xyz"])
            for leg in ("right", "left")
        ]
        return from_first_stance(np.stack(tracks, axis=1))

    measured, planned = feet("truth"), feet("reference")
    return float(np.linalg.norm(measured[-1] - planned[-1], axis=1).max())


def from_first_stance(feet: "Array") -> "Array":
    """Return feet as seen from midway between them at the first sample, shape (n, 2, 3), m.

    Parameters
    ----------
    feet : ndarray, shape (n, 2, 3)
        Right and left sole under the ankle, m.
    """
    right, left = feet[0]
    across = (left - right)[:2] / np.linalg.norm((left - right)[:2])
    turned = np.array(((across[1], -across[0], 0.0), (across[0], across[1], 0.0), (0.0, 0.0, 1.0)))
    seen: Array = (feet - 0.5 * (right + left)) @ turned.T
    return seen


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


def _tilt(window: Window) -> "Array":
    """Return how far the waist is tilted against the ground, rad."""
    roll, pitch = window.column("truth.waist_roll"), window.column("truth.waist_pitch")
    tilt: Array = np.arccos(np.clip(np.cos(roll) * np.cos(pitch), -1.0, 1.0))
    return tilt


LEGS_MEASURES: dict[str, Measure] = {
    "tilt_max": Measure(greatest(_tilt), "rad", "greatest tilt of the waist against the ground"),
    "fell": Measure(greatest(column("truth.fell")), "", "1 if the robot fell"),
    "advance_measured": Measure(advance_measured, "m", "how far the waist went ahead"),
    "feet_astray_end": Measure(
        feet_astray_end, "m", "how far the worse foot ends from its planned print"
    ),
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
