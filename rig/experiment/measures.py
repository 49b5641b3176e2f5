"""Numbers that say how well a motion was followed, taken over stretches of a log.

Every measure is a pure function of windows, one per segment. The error is the reference minus
the reading. Measures of spread pool the samples of all windows; the others report the worst
window.
"""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SLOPE_SPAN = 0.02
"""Length of the straight line that a velocity is taken from, s. With an encoder of 1 µm read at
500 Hz its noise is 14 µm/s; a 20 Hz limit cycle keeps 80 % of its amplitude."""
STICK_RATIO = 0.1
"""A pair is called stuck while slower than this share of the desired speed."""
MOVING_RATIO = 0.5
"""Only samples with at least this share of the segment's greatest desired speed are judged,
because any motion is slow where it turns."""
SETTLING_BAND = 0.02
"""Share of the step within which it is settled (the usual 2 % criterion)."""
BREAKAWAY_TRAVEL = 20e-6
"""Travel after which a pair is called moving, m: ten times what noise and quantisation show."""


class Window(NamedTuple):
    """The samples of one segment, shape (n,) each.

    Parameters
    ----------
    name : str
        The segment's.
    t : ndarray
        s since the reference started.
    position, reference : ndarray
        Measured and desired, m.
    velocity, reference_velocity : ndarray
        The slope of the measured position, and the desired velocity, m/s.
    pressures : ndarray
        Measured, Pa gauge, shape (n, channels).
    """

    name: str
    t: "Array"
    position: "Array"
    reference: "Array"
    velocity: "Array"
    reference_velocity: "Array"
    pressures: "Array"

    @property
    def error(self) -> "Array":
        """Reference minus reading, m."""
        return self.reference - self.position


Windows = Sequence[Window]


class Measure(NamedTuple):
    """A measure by its name.

    Parameters
    ----------
    compute : callable
        Takes the windows, returns the number in SI. Infinite when what it times never happens.
    unit : str
        SI unit, empty for a ratio.
    description : str
        For reports.

    Notes
    -----
    `compute` raises ValueError when the windows do not hold what it needs.
    """

    compute: Callable[[Windows], float]
    unit: str
    description: str


def local_slope(t: "Array", x: "Array", span: float = SLOPE_SPAN) -> "Array":
    """Differentiate by straight lines fitted to `span` seconds around each sample.

    Parameters
    ----------
    t : ndarray
        s, increasing, not necessarily evenly spaced, shape (n,).
    x : ndarray
        Shape (n,).

    Returns
    -------
    ndarray
        Slopes, shape (n,); the first and last half span repeat the nearest whole fit.

    References
    ----------
    A. Savitzky, M. J. E. Golay, Anal. Chem. 36(8), 1964 (first order, uneven abscissae).
    """
    n = len(t)
    if n < 2:
        return np.zeros(n)
    half = max(1, round(0.5 * span * (n - 1) / float(t[-1] - t[0])))
    width = min(2 * half + 1, n)
    times = np.lib.stride_tricks.sliding_window_view(t, width)
    times = times - times.mean(axis=1, keepdims=True)
    values = np.lib.stride_tricks.sliding_window_view(x, width)
    slopes = (times * values).sum(axis=1) / (times * times).sum(axis=1)
    before = (width - 1) // 2
    return np.pad(slopes, (before, n - len(slopes) - before), mode="edge")


def tracking_rms(windows: Windows) -> float:
    """Return the rms error, m."""
    return _rms(np.concatenate([window.error for window in windows]))


def tracking_max(windows: Windows) -> float:
    """Return the greatest absolute error, m."""
    return max(float(np.abs(window.error).max()) for window in windows)


def hunting(windows: Windows) -> float:
    """Return the greatest peak-to-peak motion of one window, m."""
    return max(float(np.ptp(window.position)) for window in windows)


def velocity_ripple(windows: Windows) -> float:
    """Return rms(v - v_ref) / rms(v_ref)."""
    desired = np.concatenate([window.reference_velocity for window in windows])
    actual = np.concatenate([window.velocity for window in windows])
    scale = _rms(desired)
    return _rms(actual - desired) / scale if scale > 0.0 else math.inf


def stick_share(windows: Windows) -> float:
    """Return the share of the time in which the pair stands though it should move."""
    stuck = moving = 0
    for window in windows:
        desired = np.abs(window.reference_velocity)
        judged = (desired > 0.0) & (desired >= MOVING_RATIO * desired.max())
        moving += int(np.count_nonzero(judged))
        slow = np.abs(window.velocity) < STICK_RATIO * desired
        stuck += int(np.count_nonzero(slow & judged))
    return stuck / moving if moving else 0.0


def rise_time(windows: Windows) -> float:
    """Return the longest time from 10 % to 90 % of a step, s."""
    times = []
    for window in windows:
        done = _step_response(window)
        low, high = _first_time(window.t, done >= 0.1), _first_time(window.t, done >= 0.9)
        times.append(high - low if math.isfinite(high) else math.inf)
    return max(times)


def overshoot(windows: Windows) -> float:
    """Return the greatest overshoot as a share of its step."""
    return max(max(0.0, float(_step_response(window).max()) - 1.0) for window in windows)


def settling_time(windows: Windows) -> float:
    """Return the longest time after which a step stays within 2 % of its size, s."""
    times = []
    for window in windows:
        outside = np.flatnonzero(np.abs(_step_response(window) - 1.0) > SETTLING_BAND)
        if len(outside) == 0:
            times.append(0.0)
        elif outside[-1] + 1 == len(window.t):
            times.append(math.inf)
        else:
            times.append(float(window.t[outside[-1] + 1] - window.t[0]))
    return max(times)


def pressure_max(windows: Windows) -> float:
    """Return the highest pressure of any chamber, Pa gauge."""
    return max(float(_pressures(window).max()) for window in windows)


def pressure_min(windows: Windows) -> float:
    """Return the lowest pressure of any chamber, Pa gauge."""
    return min(float(_pressures(window).min()) for window in windows)


def breakaway_pressure(windows: Windows) -> float:
    """Return the greatest change of the pressure difference before the pair starts, Pa."""
    changes = []
    for window in windows:
        if window.pressures.shape[1] != 2:
            raise ValueError("it needs the pressures of two chambers")
        difference = window.pressures[:, 0] - window.pressures[:, 1]
        moving = np.abs(window.position - window.position[0]) > BREAKAWAY_TRAVEL
        until = int(np.argmax(moving)) + 1 if moving.any() else len(difference)
        changes.append(float(np.abs(difference[:until] - difference[0]).max()))
    return max(changes)


MEASURES: dict[str, Measure] = {
    "tracking_rms": Measure(tracking_rms, "m", "rms error"),
    "tracking_max": Measure(tracking_max, "m", "greatest absolute error"),
    "hold_rms": Measure(tracking_rms, "m", "rms error while it holds"),
    "hold_max": Measure(tracking_max, "m", "greatest absolute error while it holds"),
    "hunting": Measure(hunting, "m", "greatest peak-to-peak motion of one hold"),
    "velocity_ripple": Measure(velocity_ripple, "", "rms velocity error over rms velocity"),
    "stick_share": Measure(stick_share, "", "share of the time that it sticks"),
    "rise_time": Measure(rise_time, "s", "longest rise from 10 % to 90 %"),
    "overshoot": Measure(overshoot, "", "greatest overshoot over its step"),
    "settling_time": Measure(settling_time, "s", "longest time to settle within 2 %"),
    "pressure_max": Measure(pressure_max, "Pa", "highest chamber pressure"),
    "pressure_min": Measure(pressure_min, "Pa", "lowest chamber pressure"),
    "breakaway_pressure": Measure(
        breakaway_pressure, "Pa", "change of pressure difference before it starts to move"
    ),
}


def _rms(values: "Array") -> float:
    return math.sqrt(float(np.mean(values * values)))


def _step_response(window: Window) -> "Array":
    """Return the share of the step that is done, 0 at the segment's start."""
    start = window.position[0]
    size = float(window.reference[-1] - start)
    if size == 0.0:
        return np.ones(len(window.position))
    response: Array = (window.position - start) / size
    return response


def _pressures(window: Window) -> "Array":
    if window.pressures.size == 0:
        raise ValueError("the log has no pressures")
    return window.pressures


def _first_time(t: "Array", condition: "NDArray[np.bool_]") -> float:
    return float(t[int(np.argmax(condition))]) if condition.any() else math.inf
