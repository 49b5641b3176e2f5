"""The fastest way along a joint path, under limits of the joints' rates and accelerations.

Reachability analysis: backwards along the path, the greatest speed from which the end can still
be reached; then forwards, always as fast as that allows. The path is in its length in joint space,
so nothing is divided by a vanishing hand speed.

References
----------
H. Pham and Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on
Reachability Analysis", IEEE Transactions on Robotics 34(3), 2018.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.arm.axis_path import AxisPath
from controllers.arm.law import Motion, MotionEnd
from controllers.arm.plan import Sample
from controllers.arm.trajectory import Trajectory
from controllers.arm.types import AT_REST

Array = NDArray[np.float64]

_POINTS = 2000
_RATE_SHARE = 0.9998
"""Of the rate limits that is used, for the same reason as below."""
_ACCELERATION_SHARE = 0.98
"""Of the acceleration limits that is used: they are met at the grid's points, not between them."""


_ROUNDS = 8
_OVER = 5e-4
"""By how much, relative, a joint may pass a limit between the grid's points."""


class Timing(NamedTuple):
    """The timing of an axis path.

    Parameters
    ----------
    s : ndarray, shape (n,)
        Grid along the path, rad.
    t : ndarray, shape (n,)
        s.
    speed : ndarray, shape (n,)
        Along the path, rad/s; its square is linear in s between the points.
    """

    s: Array
    t: Array
    speed: Array

    @property
    def duration(self) -> float:
        """Of the whole path, s."""
        return float(self.t[-1])

    def at(self, t: Array) -> tuple[Array, Array]:
        """Return place (rad) and speed (rad/s) at some instants."""
        k = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.t) - 2)
        into = t - self.t[k]
        step = self.t[k + 1] - self.t[k]
        acceleration = (self.speed[k + 1] - self.speed[k]) / step
        return (
            self.s[k] + into * (self.speed[k] + 0.5 * acceleration * into),
            self.speed[k] + acceleration * into,
        )


def retime(
    path: AxisPath,
    rate_limits: Sequence[float] | Array,
    acceleration_limits: Sequence[float] | Array | None,
) -> Timing:
    """Return the fastest timing.

    Parameters
    ----------
    path : AxisPath
        The hand goes and turns along it no faster than commanded.
    rate_limits : sequence of float
        rad/s.
    acceleration_limits : sequence of float, optional
        rad/s². None: the velocity-limited optimum, which starts, ends and turns at once.
    """
    s = np.unique(np.concatenate((np.linspace(0.0, path.length, _POINTS), path.knots)))
    s = s[np.concatenate(([True], np.diff(s) > 1e-9))]
    tangent, bend = path.joints(s, 1), path.joints(s, 2)
    limits = _RATE_SHARE * np.array(rate_limits)
    with np.errstate(divide="ignore", over="ignore"):
        greatest = np.min(limits / np.abs(tangent), axis=1)
        # The hand's own speeds, too.
        greatest = np.minimum(greatest, 1.0 / np.abs(path.way(s, 1)).max(axis=1))
    if acceleration_limits is None:
        speed = greatest
    else:
        allowed = _ACCELERATION_SHARE * np.array(acceleration_limits)
        speed = np.sqrt(_reachable(s, greatest**2, tangent, bend, allowed))
    mean = 0.5 * (speed[:-1] + speed[1:])
    t = np.concatenate(([0.0], np.cumsum(np.diff(s) / mean)))
    return Timing(s, t, speed)


def retime_within(
    path: AxisPath,
    rate_limits: Sequence[float],
    acceleration_limits: Sequence[float] | Array | None,
    period: float,
) -> Timing:
    """Return the fastest timing whose samples, a period apart, keep the limits.

    `retime` meets them at its grid's points. Past a near miss more may be asked between them: a
    joint that passes its limit there is told a lower one.
    """
    rates = np.array(rate_limits)
    accelerations = None if acceleration_limits is None else np.array(acceleration_limits)
    timing = retime(path, rates, accelerations)
    if period == 0.0:
        return timing
    told, told_accelerations = rates, accelerations
    for _ in range(_ROUNDS):
        t = np.arange(0.0, timing.duration, period)
        s, speed = timing.at(t)
        sampled = path.joints(s, 1) * speed[:, None]
        mean = np.diff(path.joints(s), axis=0) / period
        over = np.maximum(_most(sampled), _most(mean)) / rates
        told = told / np.maximum(over, 1.0)
        if accelerations is not None and told_accelerations is not None:
            harder = _most(np.diff(sampled, axis=0)) / (period * accelerations)
            told_accelerations = told_accelerations / np.maximum(harder, 1.0)
            over = np.maximum(over, harder)
        if over.max() <= 1.0 + _OVER:
            break
        timing = retime(path, told, told_accelerations)
    return timing


def _most(values: Array) -> Array:
    return np.asarray(np.abs(values).max(axis=0, initial=0.0), dtype=np.float64)


def velocity_limited_time(path: AxisPath, rate_limits: Sequence[float]) -> float:
    """Return the least time under the rate limits alone, s: what others are compared with."""
    return retime(path, rate_limits, None).duration


def _reachable(s: Array, ceiling: Array, tangent: Array, bend: Array, allowed: Array) -> Array:
    """Return the squares of the speeds of the fastest timing from rest to rest.

    With ``x`` the square of the speed and ``u`` the acceleration along the path every joint asks
    for ``|q' u + q'' x| <= a``; between two points x changes by ``2 ds u``.
    """
    ceiling = np.minimum(ceiling, _greatest_curved(tangent, bend, allowed))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        half = np.where(np.abs(tangent) > 1e-9, allowed / np.abs(tangent), np.inf)
        slope = np.where(np.abs(tangent) > 1e-9, bend / tangent, 0.0)
    halves, slopes, steps = half.tolist(), slope.tolist(), np.diff(s).tolist()
    top: list[float] = ceiling.tolist()
    top[-1] = 0.0
    for i in range(len(steps) - 1, -1, -1):
        step, following, x = 2.0 * steps[i], top[i + 1], top[i]
        for a, k in zip(halves[i], slopes[i], strict=True):
            # The hardest braking of this joint has to lead to no more than `following`.
            share = 1.0 - step * k
            if share > 0.0 and math.isfinite(a):
                x = min(x, (following + step * a) / share)
        top[i] = x
    x = top[0] = 0.0
    squares = [x]
    for i, ds in enumerate(steps):
        step = 2.0 * ds
        most = min(a - k * x for a, k in zip(halves[i], slopes[i], strict=True))
        x = min(max(x + step * most, 0.0), top[i + 1])
        squares.append(x)
    return np.array(squares)


def _greatest_curved(tangent: Array, bend: Array, allowed: Array) -> Array:
    """Return the square of the speed beyond which no acceleration suits all joints."""
    n, joints = tangent.shape
    greatest = np.full(n, np.inf)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for i in range(joints):
            alone = np.abs(tangent[:, i]) <= 1e-9
            bound = allowed[i] / np.abs(bend[:, i])
            greatest = np.where(alone, np.minimum(greatest, bound), greatest)
            for j in range(i):
                both = (np.abs(tangent[:, i]) > 1e-9) & (np.abs(tangent[:, j]) > 1e-9)
                room = allowed[i] / np.abs(tangent[:, i]) + allowed[j] / np.abs(tangent[:, j])
                apart = np.abs(bend[:, i] / tangent[:, i] - bend[:, j] / tangent[:, j])
                greatest = np.where(both, np.fmin(greatest, room / apart), greatest)
    return greatest


def follow_axis_path(
    trajectory: Trajectory,
    path: AxisPath,
    timing: Timing,
    period: float,
    end: MotionEnd,
) -> Motion:
    """Yield a sample per period along a timed joint path."""
    count = math.ceil(timing.duration / period - 1e-9)
    t = period * np.arange(count, dtype=np.float64)
    s, speed = timing.at(t)
    joints = path.joints(s).tolist()
    rates = (path.joints(s, 1) * speed[:, None]).tolist()
    scales = (path.way(s, 1) * speed[:, None]).tolist()
    gone = path.way(s)[:, 0].tolist()
    for q, rate, (linear, angular), tau in zip(joints, rates, scales, gone, strict=True):
        yield Sample(tuple(q), tuple(rate), linear, angular, trajectory.command_at(tau))
    last = tuple(path.joints(np.array([path.length]))[0].tolist())
    yield Sample(last, AT_REST, 0.0, 0.0, trajectory.command_at(gone[-1]))
    end.duration = timing.duration
