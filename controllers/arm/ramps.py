"""A motion begun and ended at rest: its first and its last stretch are gone through more slowly.

The singularity-consistent laws say with which rates the joints follow a path, from its first
instant on. Here the law's own time starts to pass, and ends, at a constant acceleration: what the
law does in between it does as ever.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.arm.axis_path import AxisPath
from controllers.arm.law import MotionEnd
from controllers.arm.motion_path import axis_path_of_motion, timed_samples
from controllers.arm.plan import Sample
from controllers.arm.retiming import Timing

Array = NDArray[np.float64]

_SHARE = 0.98
"""Of the acceleration limits that is used, as everywhere; see `retiming`."""
_LONGER = 1.05
"""From one length of a ramp that is tried to the next."""


class Ramps(NamedTuple):
    """The passing of a law's own time, s.

    Parameters
    ----------
    first, last : float
        Lengths of the ramps, s.
    peak : float
        Of the law's speed that is reached: 1 unless the path is too short for both ramps.
    own : float
        How long the law's motion takes by itself, s.
    """

    first: float
    last: float
    peak: float
    own: float

    @property
    def duration(self) -> float:
        """Of the whole motion, s."""
        cruise = self.own - 0.5 * self.peak * (self.first + self.last)
        return self.first + self.last + cruise / self.peak

    def speed_at(self, own: Array) -> Array:
        """Return how fast the law's time passes at instants of it."""
        up = np.sqrt(2.0 * own * self.peak / self.first)
        down = np.sqrt(2.0 * np.maximum(self.own - own, 0.0) * self.peak / self.last)
        return np.asarray(np.minimum(np.minimum(up, down), self.peak), dtype=np.float64)

    def instant_of(self, own: Array) -> Array:
        """Return when instants of the law's time come, s."""
        speed = self.speed_at(own)
        up = own < 0.5 * self.peak * self.first
        down = self.own - own < 0.5 * self.peak * self.last
        cruise = self.first + (own - 0.5 * self.peak * self.first) / self.peak
        rising, falling = (speed * ramp / self.peak for ramp in (self.first, self.last))
        return np.asarray(np.where(up, rising, np.where(down, self.duration - falling, cruise)))


def ramps_within(own: Array, rates: Array, limits: tuple[float, ...], period: float) -> Ramps:
    """Return the shortest ramps in which no joint needs more than its limit.

    Where the law by itself needs more there, near a singularity, the ramps add no more than half
    of the limit to it.

    Parameters
    ----------
    own : ndarray, shape (n,)
        The law's instants, s, the last at its end.
    rates : ndarray, shape (n, 6)
        Of the joints at them, rad/s.
    limits : tuple of float
        Of their accelerations, rad/s².
    period : float
        The first ramp is a whole number of pairs of it: then the law is sampled where it would be
        without a ramp, s.
    """
    most = _SHARE * np.array(limits)
    accelerations = np.abs(np.gradient(rates, own, axis=0))
    free = np.maximum(most - accelerations, 0.5 * most)
    end = float(own[-1])
    first, last = (_length(its, np.abs(rates) / free, 2.0 * period) for its in (own, end - own))
    first = 2.0 * period * math.ceil(first / (2.0 * period) - 1e-9)
    peak = min(1.0, math.sqrt(2.0 * end / (first + last)))
    return Ramps(first * peak, last * peak, peak, end)


def _length(away: Array, needed: Array, shortest: float) -> float:
    """Return how long a ramp is whose slope leaves to all joints what they need on it, s.

    Parameters
    ----------
    away : ndarray, shape (n,)
        Of each instant from the end that is at rest, in the law's time, s.
    needed : ndarray, shape (n, 6)
        The least length at each.
    shortest : float
        s.
    """
    length = shortest
    longest = 2.0 * float(away.max())
    while length < longest:
        within = away <= 0.5 * length
        if needed[within].max(initial=0.0) <= length:
            break
        length *= _LONGER
    return length


def from_rest(
    motion: list[Sample], fine: float, period: float, end: MotionEnd, limits: tuple[float, ...]
) -> tuple[AxisPath, Timing]:
    """Return the joint path of a motion and its timing with ramps.

    Parameters
    ----------
    motion : list of Sample
        `fine` apart, the last at rest at the end.
    fine, period : float
        Of the motion and of the plan that is to come, s.
    end : MotionEnd
        Of the motion; its marks are moved to when they come with the ramps.
    limits : tuple of float
        Of the joints' accelerations, rad/s².
    """
    samples, instants = timed_samples(motion, fine, end.duration)
    own = np.array(instants)
    rates = np.array([sample.velocities for sample in samples])
    positions = np.array([sample.positions for sample in samples[-2:]])
    rates[-1] = 2.0 * (positions[1] - positions[0]) / (own[-1] - own[-2]) - rates[-2]
    ramps = ramps_within(own, rates, limits, period)
    end.marks = {
        name: tuple(ramps.instant_of(np.array(its)).tolist()) for name, its in end.marks.items()
    }
    path = axis_path_of_motion(samples, instants)
    speed = np.linalg.norm(rates, axis=1) * ramps.speed_at(own)
    return path, Timing(path.knots, ramps.instant_of(own), speed)
