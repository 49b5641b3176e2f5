"""Numbers that say how well the spherical joint followed its motion.

Where the joint is simulated, the marker is judged by where it truly was; on a rig, by where
the controller believes it to be. Measures of spread pool the samples of all windows; the others
report the worst window.
"""

from typing import TYPE_CHECKING

import numpy as np

from rig.experiment.measure import (
    Measure,
    Samples,
    Window,
    Windows,
    column,
    greatest,
    lengths,
    rms,
    rms_of,
)
from rig.mechanisms.joint.motion import ALL
from rig.runtime.phases import Timings

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

CHANNELS = ("ch1", "ch2", "ch3", "ch4")
PAIRS = (("ch1", "ch3"), ("ch4", "ch2"))
"""Opposite wires: what one pulls in, the other one lets go."""

_STUCK = 0.5
"""The plant's flag of a channel that sticks is 0 or 1."""
_MOVING_RATIO = 0.3
"""Sticking counts where a channel should move with at least this share of its greatest speed."""


def pair_errors(window: Window) -> "Array":
    """Return the errors of both pairs, m, shape (n, 2).

    A pair's error is half the difference of its two rods' errors: what turns the ring. The mean
    of the two is the wires' stretch, which no controller can take out.
    """
    return np.column_stack(
        [0.5 * (_error(window, one) - _error(window, other)) for one, other in PAIRS]
    )


def marker_error(window: Window) -> "Array":
    """Return the marker's position less its reference, m, shape (n, 3)."""
    return _marker(window) - window.columns("reference.marker_")


def _marker_distance(window: Window) -> "Array":
    """Return the marker's distance from its reference, m, shape (n,)."""
    return lengths(marker_error(window))


def _fused_distance(window: Window) -> "Array":
    """Return the distance of the estimated marker from the true one, m, shape (n,)."""
    return lengths(window.columns("estimate.marker_") - window.columns("truth.marker_"))


def radial_error(window: Window) -> "Array":
    """Return how far the marker is from the circle that its reference is on, m, shape (n,).

    The distance from the vertical axis, of the marker less that of the reference.
    """
    actual, desired = _marker(window), window.columns("reference.marker_")
    return np.hypot(actual[:, 0], actual[:, 1]) - np.hypot(desired[:, 0], desired[:, 1])


def wire_hold_rms(windows: Windows) -> float:
    """Return the rms error of the worst pair of the worst window, m."""
    return max(rms(errors) for window in windows for errors in pair_errors(window).T)


def tension_min(windows: Windows) -> float:
    """Return the least tension of any wire, N.

    Over the segment ``all`` that is from the cycle in which control takes over to the last one
    before the release: approach, motion, and every dwell. Energising and release are left out,
    because there is no pull to keep: a wire has none before its chamber has pressure, and it is
    the release that takes the pressure off.
    """
    return min(float(_tensions(window, _controlled).min()) for window in windows)


def tension_max(windows: Windows) -> float:
    """Return the greatest tension of any wire, N.

    Over the segment ``all`` that is in every recorded cycle, energising and release included.
    """
    return max(float(_tensions(window, Samples.recorded).max()) for window in windows)


def wire_stick_share(windows: Windows) -> float:
    """Return the share of the time in which a channel sticks though it should move."""
    stuck = moving = 0
    for window in windows:
        for channel in CHANNELS:
            desired = np.abs(window.slope(f"reference.rod_{channel}"))
            judged = (desired > 0.0) & (desired >= _MOVING_RATIO * desired.max())
            moving += int(np.count_nonzero(judged))
            sticks = window.column(f"truth.sticking_{channel}") > _STUCK
            stuck += int(np.count_nonzero(sticks & judged))
    return stuck / moving if moving else 0.0


JOINT_MEASURES: dict[str, Measure] = {
    "wire_rms": Measure(rms_of(pair_errors), "m", "rms error of the wire pairs"),
    "wire_max": Measure(greatest(pair_errors), "m", "greatest error of a wire pair"),
    "wire_hold_rms": Measure(wire_hold_rms, "m", "rms error of the worst pair while it holds"),
    "marker_rms": Measure(
        rms_of(_marker_distance), "m", "rms distance of the marker from its reference"
    ),
    "marker_max": Measure(
        greatest(_marker_distance), "m", "greatest distance of the marker from its reference"
    ),
    "radial_rms": Measure(rms_of(radial_error), "m", "rms distance of the marker from its circle"),
    "fused_rms": Measure(
        rms_of(_fused_distance), "m", "rms distance of the estimated marker from the true one"
    ),
    "tension_min": Measure(tension_min, "N", "least tension of any wire"),
    "tension_max": Measure(tension_max, "N", "greatest tension of any wire"),
    "twist_max": Measure(greatest(column("truth.twist")), "rad", "greatest twist of the ring"),
    "wire_stick_share": Measure(wire_stick_share, "", "share of the time that a channel sticks"),
}


def _error(window: Window, channel: str) -> "Array":
    return window.error(f"rod_{channel}")


def _marker(window: Window) -> "Array":
    source = "truth" if window.has("truth.marker_x") else "estimate"
    return window.columns(f"{source}.marker_")


def _controlled(samples: Samples, name: str) -> "Array":
    return samples.controlled(name, Timings().energise)


def _tensions(window: Window, whole: "Callable[[Samples, str], Array]") -> "Array":
    """Return the four tensions, N, shape (n, 4); of the segment ``all`` as `whole` takes them."""
    source = "truth" if window.has("truth.tension_ch1") else "estimate"
    if window.segment.name != ALL:
        return window.columns(f"{source}.tension_")
    names = [f"{source}.tension_{name}" for name in CHANNELS]
    return np.column_stack([whole(window.samples, name) for name in names])
