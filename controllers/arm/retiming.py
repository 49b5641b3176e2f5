"""The fastest way along a joint path, under limits of rates, accelerations and torques.

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
from controllers.arm.dynamics.chain import ArmTorques
from controllers.arm.dynamics.limits import PathTorques, shares_between
from controllers.arm.law import Motion, MotionEnd
from controllers.arm.plan import Sample
from controllers.arm.trajectory import Trajectory
from controllers.arm.types import AT_REST
from controllers.motion import check_length
from controllers.reachable_speeds import FastestTimings, Rows

Array = NDArray[np.float64]

_POINTS = 2000
_RATE_SHARE = 0.9998
"""Of the rate limits that is used, for the same reason as below."""
_ACCELERATION_SHARE = 0.98
"""Of the acceleration limits that is used: they are met at the grid's points, not between them."""


_ROUNDS = 16
_LOCAL_ROUNDS = 10
"""In so many of them a joint is told a lower limit only where it has passed its own."""
_STRETCHES = 8
"""After them: so often the whole motion is slowed by what one joint needs."""
_OVER = 5e-4
"""By how much, relative, a joint may pass a limit between the grid's points."""
_RUBBINGS = 8
"""How often viscous friction is taken anew at the speeds that came of it, at most."""
_SETTLED = 1e-4
"""Change of the squared speeds, relative to the greatest, at which that ends."""


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

    def stretched(self, factor: float) -> "Timing":
        """Return the same way in so many times its time."""
        return Timing(self.s, self.t * factor, self.speed / factor)

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


class Strain(NamedTuple):
    """By how much more of its limits each joint is said to need at the points of the grid.

    Parameters
    ----------
    rates, accelerations : ndarray, shape (n, 6)
        1 or more.
    hand : ndarray, shape (n, 1)
        The same of the hand's own speeds.
    torques : ndarray, shape (n, 6)
        The same of what moves the joints, beside weight and dry friction.
    """

    rates: Array
    accelerations: Array
    hand: Array
    torques: Array


def grid_of(path: AxisPath) -> Array:
    """Return the places of a path at which its timing is worked out, rad, shape (n,)."""
    s = np.unique(np.concatenate((np.linspace(0.0, path.length, _POINTS), path.knots)))
    for corner in path.corners:
        s = s[(np.abs(s - corner) > 1e-9) | (s == corner)]
    return np.asarray(s[np.concatenate(([True], np.diff(s) > 1e-9))], dtype=np.float64)


def retime(
    path: AxisPath,
    rate_limits: Sequence[float] | Array,
    acceleration_limits: Sequence[float] | Array | None,
    strain: Strain | None = None,
    torques: PathTorques | None = None,
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
    strain : Strain, optional
        At the points of `grid_of`.
    torques : PathTorques, optional
        At the same points; only beside limits of accelerations.
    """
    s = grid_of(path)
    tangent, bend = path.joints(s, 1), path.joints(s, 2)
    limits = _RATE_SHARE * np.array(rate_limits)
    way = path.way(s, 1)
    rated, gone = (tangent, way) if strain is None else (tangent * strain.rates, way * strain.hand)
    with np.errstate(divide="ignore", over="ignore"):
        greatest = np.min(limits / np.abs(rated), axis=1)
        greatest = np.minimum(greatest, 1.0 / np.abs(gone).max(axis=1))  # the hand's own speeds
    if acceleration_limits is None:
        speed = greatest
    else:
        greatest[np.isin(s, path.corners)] = 0.0
        allowed = _ACCELERATION_SHARE * np.array(acceleration_limits)
        if strain is not None:
            tangent, bend = tangent * strain.accelerations, bend * strain.accelerations
        rows = Rows.of_accelerations(tangent, bend, allowed)
        if torques is None:
            speed = np.sqrt(FastestTimings(s, rows).below(greatest**2))
        else:
            needs = 1.0 if strain is None else strain.torques
            speed = np.sqrt(_with_torques(s, greatest**2, rows, torques, needs))
    mean = 0.5 * (speed[:-1] + speed[1:])
    t = np.concatenate(([0.0], np.cumsum(np.diff(s) / mean)))
    return Timing(s, t, speed)


def _with_torques(
    s: Array, ceiling: Array, rows: Rows, torques: PathTorques, strain: Array | float
) -> Array:
    """Return the squared speeds under torques as well, whose viscous friction grows with a root."""
    squares = FastestTimings(s, rows).below(ceiling)
    for _ in range(_RUBBINGS):
        before = squares
        both = rows.beside(torques.rows(before, strain))
        squares = FastestTimings(s, both).below(ceiling)
        if np.abs(squares - before).max() <= _SETTLED * before.max():
            break
    return squares


def retime_within(
    path: AxisPath,
    rate_limits: Sequence[float],
    acceleration_limits: Sequence[float] | Array | None,
    period: float,
    torques: ArmTorques | None,
    longest: float,
) -> Timing:
    """Return the fastest timing whose samples, a period apart, keep the limits.

    `retime` meets them at its grid's points. Past a near miss more may be asked between them: a
    joint that passes its limit is told a lower one there, if that does not do, everywhere, and at
    last all of the motion is slowed.

    Raises
    ------
    LongMotion
        It takes longer than `longest`, s.
    """
    grid = grid_of(path)
    needed = None if torques is None else PathTorques(torques, path, grid)
    timing = retime(path, rate_limits, acceleration_limits, None, needed)
    if period == 0.0:
        return timing
    strain = Strain(*(np.ones((len(grid), width)) for width in (6, 6, 1, 6)))
    for k in range(_ROUNDS + _STRETCHES):
        check_length(timing.duration, longest)
        s, speed = timing.at(np.arange(0.0, timing.duration, period))
        if len(s) < 2:
            break
        shares = _shares(path, s, speed, rate_limits, acceleration_limits, period)
        if torques is not None:
            rates = path.joints(s, 1) * speed[:, None]
            used = shares_between(torques, path.joints(s), rates, period)
            shares = shares._replace(torques=used)
        if max(its.max() for its in shares) <= 1.0 + _OVER:
            break
        if k >= _ROUNDS:
            timing = timing.stretched(_needed(shares))
            continue
        if k >= _LOCAL_ROUNDS:
            shares = Strain(*(np.tile(its.max(axis=0), (len(its), 1)) for its in shares))
        strain = Strain(
            *(told * _at_grid(its, s, grid) for told, its in zip(strain, shares, strict=True))
        )
        timing = retime(path, rate_limits, acceleration_limits, strain, needed)
    return timing


def _needed(shares: Strain) -> float:
    """Return how many times as long a motion has to take that uses these shares of its limits."""
    worst = {name: float(its.max(initial=0.0)) for name, its in shares._asdict().items()}
    squares = max(worst.pop("accelerations"), worst.pop("torques", 0.0))
    return max(math.sqrt(squares), *worst.values())


def _shares(
    path: AxisPath,
    s: Array,
    speed: Array,
    rate_limits: Sequence[float],
    acceleration_limits: Sequence[float] | Array | None,
    period: float,
) -> Strain:
    """Return what is used of each limit from one sample to the next, at places `s` (rad)."""

    def fastest(values: Array, rates: Array) -> Array:
        mean = np.abs(np.diff(values, axis=0)) / period
        at = np.abs(rates)
        return np.asarray(np.maximum(np.maximum(at[:-1], at[1:]), mean), dtype=np.float64)

    rates, way = path.joints(s, 1) * speed[:, None], path.way(s, 1) * speed[:, None]
    over = fastest(path.joints(s), rates) / np.array(rate_limits)
    hand = fastest(path.way(s), way).max(axis=1, keepdims=True)
    harder = np.zeros_like(over)
    if acceleration_limits is not None:
        most = period * np.array(acceleration_limits)
        harder = np.abs(np.diff(rates, axis=0)) / most
        # Drives see the positions alone: next to a corner of the joints' path these say more.
        turns = np.abs(np.diff(path.joints(s), 2, axis=0)) / (period * most)
        harder[1:], harder[:-1] = np.maximum(harder[1:], turns), np.maximum(harder[:-1], turns)
    return Strain(over, harder, hand, np.zeros_like(over))


def _at_grid(shares: Array, s: Array, grid: Array) -> Array:
    """Return the greatest shares of limits between samples at the points of the grid, 1 or more.

    What lies between two samples counts for the next ones on either side: they move a little.
    """
    padded = np.vstack((shares[:1], shares, shares[-1:]))
    wide = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    interval = np.clip(np.searchsorted(s, grid, side="right") - 1, 0, len(shares) - 1)
    return np.asarray(np.maximum(wide[interval], 1.0), dtype=np.float64)


def velocity_limited_time(path: AxisPath, rate_limits: Sequence[float]) -> float:
    """Return the least time under the rate limits alone, s: what others are compared with."""
    return retime(path, rate_limits, None).duration


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
