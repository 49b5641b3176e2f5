"""The greatest speeds along a curve of joints from which accelerations still lead to rest.

Backwards along the curve, the greatest speed from which the end can be reached; then forwards,
always as fast as that allows.

References
----------
H. Pham and Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on
Reachability Analysis", IEEE Transactions on Robotics 34(3), 2018.
"""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_NO_ACCELERATION: Final = 1e-9
"""Coefficient of the acceleration below which a limit says nothing of it."""


def reachable(s: Array, ceiling: Array, tangent: Array, bend: Array, allowed: Array) -> Array:
    """Return the squares of the speeds of the fastest timing from rest to rest.

    Parameters
    ----------
    s : ndarray, shape (n,)
        Grid along the curve.
    ceiling : ndarray, shape (n,)
        Squares of the speeds that are permitted, whatever the accelerations.
    tangent, bend : ndarray, shape (n, joints)
        First and second derivative of the joints by s.
    allowed : ndarray, shape (joints,)
        Accelerations, rad/s².

    Notes
    -----
    With ``x`` the square of the speed and ``u`` the acceleration along the path every joint asks
    for ``|q' u + q'' x| <= a``; between two points x changes by ``2 ds u``.
    """
    most = np.broadcast_to(allowed, tangent.shape)
    return reachable_within(s, ceiling, Rows(tangent, bend, -most, most))


class Rows(NamedTuple):
    """Limits of what is linear in acceleration and squared speed: ``low <= m u + b x <= high``.

    Parameters
    ----------
    m, b : ndarray, shape (n, rows)
        At each point of a grid.
    low, high : ndarray, shape (n, rows)
        Below and above 0: at rest all of them are kept.
    """

    m: Array
    b: Array
    low: Array
    high: Array

    def beside(self, other: "Rows") -> "Rows":
        """Return both kinds of limits at once."""
        return Rows(*(np.hstack(pair) for pair in zip(self, other, strict=True)))


def reachable_within(s: Array, ceiling: Array, rows: Rows) -> Array:
    """Return the squares of the speeds of the fastest timing from rest to rest under any limits.

    Parameters are those of `reachable`, with `Rows` for the joints' accelerations.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        moves: NDArray[np.bool_] = np.abs(rows.m) > _NO_ACCELERATION
        size = np.abs(rows.m)
        up = np.where(moves, np.where(rows.m > 0.0, rows.high, -rows.low) / size, np.inf)
        down = np.where(moves, np.where(rows.m > 0.0, -rows.low, rows.high) / size, np.inf)
        slope = np.where(moves, rows.b / rows.m, 0.0)
    ceiling = np.minimum(ceiling, _greatest_curved(rows, up, down, slope, moves))
    ups, downs, slopes = up.tolist(), down.tolist(), slope.tolist()
    steps = np.diff(s).tolist()
    top: list[float] = ceiling.tolist()
    top[-1] = 0.0
    for i in range(len(steps) - 1, -1, -1):
        step, following, x = 2.0 * steps[i], top[i + 1], top[i]
        for a, k in zip(downs[i], slopes[i], strict=True):
            # The hardest braking of this joint has to lead to no more than `following`.
            share = 1.0 - step * k
            if share > 0.0 and math.isfinite(a):
                x = min(x, (following + step * a) / share)
        top[i] = x
    x = top[0] = 0.0
    squares = [x]
    for i, ds in enumerate(steps):
        step = 2.0 * ds
        most = min(a - k * x for a, k in zip(ups[i], slopes[i], strict=True))
        x = min(max(x + step * most, 0.0), top[i + 1])
        squares.append(x)
    return np.array(squares)


def _greatest_curved(
    rows: Rows, up: Array, down: Array, slope: Array, moves: NDArray[np.bool_]
) -> Array:
    """Return the square of the speed beyond which no acceleration suits all rows."""
    n, count = rows.m.shape
    greatest = np.full(n, np.inf)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for i in range(count):
            b = rows.b[:, i]
            bound = np.where(b > 0.0, rows.high[:, i], -rows.low[:, i]) / np.abs(b)
            greatest = np.where(moves[:, i], greatest, np.minimum(greatest, bound))
            for j in range(i):
                apart = slope[:, i] - slope[:, j]
                room = np.where(apart > 0.0, up[:, i] + down[:, j], up[:, j] + down[:, i]) / np.abs(
                    apart
                )
                greatest = np.where(moves[:, i] & moves[:, j], np.fmin(greatest, room), greatest)
    return greatest
