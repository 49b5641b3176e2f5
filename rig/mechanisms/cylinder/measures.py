"""Numbers that say how well an antagonistic pair followed its motion.

The error is the reference minus the reading. Measures of spread pool the samples of all
windows; the others report the worst window.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from rig.experiment.measure import (
    Measure,
    NoSuchMotion,
    Window,
    Windows,
    greatest,
    pooled,
    rms,
    rms_of,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STICK_RATIO = 0.1
"""A pair is called stuck while slower than this share of the desired speed."""
MOVING_RATIO = 0.5
"""Only samples with at least this share of the segment's greatest desired speed are judged,
because any motion is slow where it turns."""
SETTLING_BAND = 0.02
"""Share of the step within which it is settled (the usual 2 % criterion)."""
_LEAST_STEP = 0.1e-3
"""A pair that holds is off by as much as friction keeps it: less than this is no step, m."""
_RISE = 0.3
"""Share of its segment within which the reference of a step has to be there."""
JUMP_RATIO = 0.5
"""A reference that jumps by less than this share of the way to it is only held."""
BREAKAWAY_TRAVEL = 20e-6
"""Travel after which a pair is called moving, m: ten times what noise and quantisation show."""


def _error(window: Window) -> "Array":
    return window.error("position")


def hunting(windows: Windows) -> float:
    """Return the greatest peak-to-peak motion of one window, m."""
    return max(float(np.ptp(_position(window))) for window in windows)


def velocity_ripple(windows: Windows) -> float:
    """Return rms(v - v_ref) / rms(v_ref)."""
    desired = pooled(windows, lambda window: window.column("reference.velocity"))
    actual = pooled(windows, lambda window: window.slope("reading.position"))
    scale = rms(desired)
    return rms(actual - desired) / scale if scale > 0.0 else math.inf


def stick_share(windows: Windows) -> float:
    """Return the share of the time in which the pair stands though it should move."""
    stuck = moving = 0
    for window in windows:
        desired = np.abs(window.column("reference.velocity"))
        judged = (desired > 0.0) & (desired >= MOVING_RATIO * desired.max())
        moving += int(np.count_nonzero(judged))
        slow = np.abs(window.slope("reading.position")) < STICK_RATIO * desired
        stuck += int(np.count_nonzero(slow & judged))
    return stuck / moving if moving else 0.0


def rise_time(windows: Windows) -> float:
    """Return the longest time from 10 % to 90 % of a step, s."""
    times = []
    for window in steps_of(windows):
        done = step_response(window)
        low, high = first_time(window.t, done >= 0.1), first_time(window.t, done >= 0.9)
        times.append(high - low if math.isfinite(high) else math.inf)
    return max(times)


def overshoot(windows: Windows) -> float:
    """Return the greatest overshoot as a share of its step."""
    return max(max(0.0, float(step_response(window).max()) - 1.0) for window in steps_of(windows))


def settling_time(windows: Windows) -> float:
    """Return the longest time after which a step stays within 2 % of its size, s."""
    times = []
    for window in steps_of(windows):
        outside = np.flatnonzero(np.abs(step_response(window) - 1.0) > SETTLING_BAND)
        if len(outside) == 0:
            times.append(0.0)
        elif outside[-1] + 1 == len(window.t):
            times.append(math.inf)
        else:
            times.append(float(window.t[outside[-1] + 1] - window.t[0]))
    return max(times)


def pressure_max(windows: Windows) -> float:
    """Return the highest pressure of any chamber, Pa gauge."""
    return max(float(window.columns("reading.pressure_").max()) for window in windows)


def pressure_min(windows: Windows) -> float:
    """Return the lowest pressure of any chamber, Pa gauge."""
    return min(float(window.columns("reading.pressure_").min()) for window in windows)


def breakaway_pressure(windows: Windows) -> float:
    """Return the greatest change of the pressure difference before the pair starts, Pa."""
    changes = []
    for window in windows:
        pressures, position = window.columns("reading.pressure_"), _position(window)
        if pressures.shape[1] != 2:
            raise ValueError("it needs the pressures of two chambers")
        difference = pressures[:, 0] - pressures[:, 1]
        moving = np.abs(position - position[0]) > BREAKAWAY_TRAVEL
        until = int(np.argmax(moving)) + 1 if moving.any() else len(difference)
        changes.append(float(np.abs(difference[:until] - difference[0]).max()))
    return max(changes)


PAIR_MEASURES: dict[str, Measure] = {
    "tracking_rms": Measure(rms_of(_error), "m", "rms of reference minus reading"),
    "tracking_max": Measure(greatest(_error), "m", "greatest absolute error"),
    "hold_rms": Measure(rms_of(_error), "m", "rms error while it holds"),
    "hold_max": Measure(greatest(_error), "m", "greatest absolute error while it holds"),
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


def _position(window: Window) -> "Array":
    return window.column("reading.position")


def steps_of(windows: Windows) -> list[Window]:
    """Return the windows that begin with a jump of the reference, or a step's rise, and stay then.

    Raises
    ------
    NoSuchMotion
        None does: a smooth move or a hold has no step response.
    """
    steps = [window for window in windows if _is_step(window)]
    if not steps:
        raise NoSuchMotion("no segment is a step")
    return steps


def _is_step(window: Window) -> bool:
    reference, before = window.column("reference.position"), window.before("reference.position")
    start, end = float(_position(window)[0]), float(reference[-1])
    least = JUMP_RATIO * abs(end - start)
    # Rounding may take a sample from before the jump, and a mark is one cycle before its step.
    rises = window.segment.name.startswith("step ")
    first = max(2, int(_RISE * len(reference))) if rises else 2
    rest = reference[first:] if len(reference) > first else reference
    stays = float(np.ptp(rest)) <= SETTLING_BAND * abs(end - start)
    jump = abs(end - (start if before is None else before))
    return stays and jump >= max(least, _LEAST_STEP)


def step_response(window: Window) -> "Array":
    """Return the share of the step that is done, 0 at the segment's start."""
    position = _position(window)
    start = position[0]
    size = float(window.column("reference.position")[-1] - start)
    if size == 0.0:
        return np.ones(len(position))
    response: Array = (position - start) / size
    return response


def first_time(t: "Array", condition: "NDArray[np.bool_]") -> float:
    """Return when a condition is true for the first time; infinity: never."""
    return float(t[int(np.argmax(condition))]) if condition.any() else math.inf
