"""Numbers that say how well the cranks turned together."""

import numpy as np

from rig.experiment.measure import Measure, Windows, pooled, rms


def turning_rms(windows: Windows) -> float:
    """Return the rms of the mean crank's error, rad."""
    return rms(
        pooled(
            windows,
            lambda window: 0.5 * (window.error("position_left") + window.error("position_right")),
        )
    )


def rod_twist(windows: Windows) -> float:
    """Return the rod's greatest twist, rad."""
    return max(float(np.abs(window.column("reading.twist")).max()) for window in windows)


CRANK_MEASURES = {
    "turning_rms": Measure(turning_rms, "rad", "rms error of the mean crank"),
    "rod_twist": Measure(rod_twist, "rad", "greatest twist of the rod"),
}
