"""By how much a camera is later than its stamps say, from a whole run.

The marker that the encoders tell is shifted in time until it lies where the camera saw it. Other
things part the two as well, and are fitted with each shift: a camera that is turned or displaced,
encoders of a wrong scale, and friction, which holds the marker back by a distance along its way
that hardly depends on its speed. What of friction grows with the speed cannot be told from
lateness: `rig.mechanisms.joint.calibration.camera`.
"""

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from rig.hal.motion import Note

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rig.hal.hindsight import Logged

    Array = NDArray[np.float64]

WRONG: Final = 3e-3
"""A latency that is surely wrong, and may be so by more than this, is said, s."""
_LIKENESS: Final = 1e-3
"""What viscous friction may pass for, s, widens every interval."""
_SHIFTS: "Final[Array]" = 1e-3 * np.arange(-60.0, 101.0, 5.0)
"""That are tried first, s …"""
_CLOSER: "Final[Array]" = 1e-3 * np.arange(-8.0, 9.0)
"""… and around the best of them, s."""
_MOVES: Final = 3e-3
"""Below this speed nothing shows when an image was taken, m/s."""
_FITTED: Final = 20e-3
"""Half of the time over which a speed is taken, s."""
_BLOCK: Final = 1.0
"""Samples within this time are not independent, s."""
_LEAST_BLOCKS: Final = 4
_LEAST_SAMPLES: Final = 10
"""Fewer in a block are left out."""
_SIGMAS: Final = 2.5
"""Half of an interval, in standard deviations: with few blocks 95 %."""


class Lateness(NamedTuple):
    """The lateness of a camera.

    Parameters
    ----------
    late : float
        By how much the exposures were earlier than their stamps, s.
    uncertain : float
        Half of the interval in which it lies, s.
    """

    late: float
    uncertain: float


def remark_on_latency(logged: "Logged", name: str, latency: float | None) -> tuple[Note, ...]:
    """Return what is to be said of a camera's latency; nothing if it may well be right.

    Parameters
    ----------
    logged : callable
        Returns a column of a joint's log by its name.
    name : str
        Of the camera.
    latency : float or None
        As the profile has it, s.
    """
    found = lateness_of(logged)
    if found is None or abs(found.late) <= max(found.uncertain, WRONG - found.uncertain):
        return ()
    interval = f"± {found.uncertain * 1e3:.1f} ms"
    if latency is None:
        what = f"its images are {found.late * 1e3:.1f} {interval} older than their stamps say"
    else:
        seen = f"{(latency + found.late) * 1e3:.1f} {interval}"
        what = f"the profile says a latency of {latency * 1e3:.3g} ms, I see {seen}"
    return (Note("camera", f"{name}: {what}; `rig calibrate RIG camera` measures it"),)


def lateness_of(logged: "Logged") -> Lateness | None:
    """Return how late the camera of a joint's log is; None if its motion does not show it."""
    t, age = logged("clock"), logged("reading.marker_age")
    marker = np.column_stack([logged(f"estimate.encoder_marker_{axis}") for axis in "xyz"])
    seen = np.column_stack([logged(f"reading.marker_{axis}") for axis in "xyz"])
    known = np.any(marker != 0.0, axis=1)  # before control there is no estimate
    stamps = logged("reading.marker_time")
    fresh = (np.diff(stamps, prepend=stamps[:1]) != 0.0) & (age >= 0.0)
    if np.count_nonzero(known) < 2 or not fresh.any():
        return None
    read = t[known] - logged("reading.age")[known]
    return fit_lateness(read, marker[known], stamps[fresh], seen[fresh])


def fit_lateness(t: "Array", marker: "Array", stamps: "Array", seen: "Array") -> Lateness | None:
    """Return by how much stamps are too late; None if too little moves.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Of the encoders' readings, s.
    marker : ndarray, shape (n, 3)
        Where they put the marker, m.
    stamps : ndarray, shape (m,)
        Of the images, s.
    seen : ndarray, shape (m, 3)
        Where they show the marker, m.
    """
    velocity = _velocity(t, marker)
    inside = (stamps - _SHIFTS[-1] > t[0]) & (stamps - _SHIFTS[0] < t[-1])
    stamps, seen = stamps[inside], seen[inside]
    speed = np.linalg.norm(_at(stamps, t, velocity), axis=1)
    stamps, seen = stamps[speed > _MOVES], seen[speed > _MOVES]
    numbers = np.floor((stamps - stamps[:1].sum()) / _BLOCK).astype(int)
    blocks = [numbers == k for k in np.unique(numbers)]
    blocks = [block for block in blocks if np.count_nonzero(block) >= _LEAST_SAMPLES]
    if len(blocks) < _LEAST_BLOCKS:
        return None

    def left(shifts: "Array") -> "Array":
        there = [(_at(stamps - s, t, marker), _at(stamps - s, t, velocity)) for s in shifts]
        squares = np.array([_squares(seen, *place) for place in there])
        return np.column_stack([squares[:, block].sum(axis=1) for block in blocks])

    shifts = _CLOSER + _SHIFTS[int(np.argmin(left(_SHIFTS).sum(axis=1)))]
    of_blocks = left(shifts)
    whole = of_blocks.sum(axis=1)
    late = _least(shifts, whole)
    # Each block left out once (B. Efron, "Bootstrap methods: another look at the jackknife",
    # Annals of Statistics 7(1), 1979).
    without = np.array([_least(shifts, whole - block) for block in of_blocks.T])
    count = len(blocks)
    deviation = math.sqrt((count - 1) / count * float(np.sum((without - without.mean()) ** 2)))
    return Lateness(late, _SIGMAS * deviation + _LIKENESS)


def _squares(seen: "Array", marker: "Array", velocity: "Array") -> "Array":
    """Return what is left between camera and encoders of each sample, m², shape (m,)."""
    speed = np.maximum(np.linalg.norm(velocity, axis=1), _MOVES)
    shapes = [velocity / speed[:, None], marker]
    for axis in np.eye(3):
        shapes += [np.broadcast_to(axis, marker.shape), np.cross(axis, marker)]
    design = np.stack(shapes, axis=-1).reshape(-1, len(shapes))
    gap = (seen - marker).ravel()
    weights = np.linalg.pinv(design.T @ design) @ (design.T @ gap)
    left = (gap - design @ weights).reshape(seen.shape)
    found: Array = np.sum(left * left, axis=1)
    return found


def _least(shifts: "Array", cost: "Array") -> float:
    """Return the shift at which a cost is least, as a parabola has it, s."""
    k = min(max(int(np.argmin(cost)), 1), len(cost) - 2)
    before, here, after = (float(cost[k + i]) for i in (-1, 0, 1))
    bend = before - 2.0 * here + after
    step = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(shifts[k] + min(max(step, -1.0), 1.0) * (shifts[1] - shifts[0]))


def _velocity(t: "Array", marker: "Array") -> "Array":
    """Return the marker's velocity by straight lines through its neighbours, m/s, shape (n, 3)."""
    step = float(np.median(np.diff(t)))
    half = max(1, round(_FITTED / step))
    k = np.arange(-half, half + 1)
    weights = k[::-1] / (float((k**2).sum()) * step)
    padded = np.pad(marker, ((half, half), (0, 0)), mode="edge")
    return np.column_stack([np.convolve(row, weights, "valid") for row in padded.T])


def _at(when: "Array", t: "Array", signal: "Array") -> "Array":
    return np.column_stack([np.interp(when, t, row) for row in signal.T])
