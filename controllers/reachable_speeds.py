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

    @classmethod
    def of_accelerations(cls, tangent: Array, bend: Array, allowed: Array) -> "Rows":
        """Return the limits of joints' accelerations.

        Parameters
        ----------
        tangent, bend : ndarray, shape (n, joints)
            First and second derivative of the joints by the place on the curve.
        allowed : ndarray, shape (joints,)
            Accelerations, rad/s².

        Notes
        -----
        With ``x`` the square of the speed and ``u`` the acceleration along the path every joint
        asks for ``|q' u + q'' x| <= a``.
        """
        most = np.broadcast_to(allowed, tangent.shape)
        return cls(tangent, bend, -most, most)


class FastestTimings:
    """The fastest timings along a curve from rest to rest, each below speeds of its own.

    Parameters
    ----------
    s : ndarray, shape (n,)
        Grid along the curve.
    rows : Rows
        At each point of it.

    Notes
    -----
    Between two points the square of the speed changes by ``2 ds u``. Most rows bind nowhere near:
    those that cannot, whatever comes before or after, are left out at once, and only the others
    are looked at point by point. No digit depends on it.
    """

    def __init__(self, s: Array, rows: Rows) -> None:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            moves: NDArray[np.bool_] = np.abs(rows.m) > _NO_ACCELERATION
            size = np.abs(rows.m)
            up = np.where(moves, np.where(rows.m > 0.0, rows.high, -rows.low) / size, np.inf)
            down = np.where(moves, np.where(rows.m > 0.0, -rows.low, rows.high) / size, np.inf)
            slope = np.where(moves, rows.b / rows.m, 0.0)
            self._curved = _greatest_curved(rows, up, down, slope, moves)
            self._up, self._slope = up[:-1], slope[:-1]
            self._steps = 2.0 * np.diff(s)
            # The hardest braking of a joint has to lead to no more than the point that follows.
            self._gained = self._steps[:, None] * down[:-1]
            self._share = 1.0 - self._steps[:, None] * self._slope
            brakes = (self._share > 0.0) & np.isfinite(down[:-1])
            self._least = np.where(brakes, self._gained / self._share, np.inf)

    def below(self, ceiling: Array) -> Array:
        """Return the squares of the speeds of the fastest timing, shape (n,).

        Parameters
        ----------
        ceiling : ndarray, shape (n,)
            Squares of the speeds that are permitted, whatever the accelerations.
        """
        ceiling = np.minimum(ceiling, self._curved)
        ceiling[-1] = 0.0
        return self._forwards(self._backwards(ceiling))

    def _backwards(self, ceiling: Array) -> Array:
        """Return the greatest squares from which the end can be reached; 0 at the start."""
        top: list[float] = ceiling.tolist()
        binding = self._least < ceiling[:-1, None]  # even if the next point is at rest
        gained, share = self._gained[binding].tolist(), self._share[binding].tolist()
        k = len(gained)
        for i, count in reversed([*enumerate(binding.sum(axis=1).tolist())]):
            x, following = top[i], top[i + 1]
            for _ in range(count):
                k -= 1
                x = min(x, (following + gained[k]) / share[k])
            top[i] = x
        top[0] = 0.0
        return np.array(top)

    def _forwards(self, top: Array) -> Array:
        """Return the squares of going from the start as fast as accelerations and `top` allow."""
        up, slope, highest = self._up, self._slope, top[:-1, None]
        least = up - np.maximum(slope, 0.0) * highest
        most = up - np.minimum(slope, 0.0) * highest
        binding = least <= most.min(axis=1, keepdims=True)
        ups, slopes = up[binding].tolist(), slope[binding].tolist()
        x, k = 0.0, 0
        squares = [x]
        following = top[1:].tolist()
        for i, (step, count) in enumerate(
            zip(self._steps.tolist(), binding.sum(axis=1).tolist(), strict=True)
        ):
            harder = math.inf
            for _ in range(count):
                harder = min(harder, ups[k] - slopes[k] * x)
                k += 1
            x = min(max(x + step * harder, 0.0), following[i])
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
