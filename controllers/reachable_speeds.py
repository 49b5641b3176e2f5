"""The greatest speeds along a curve of joints from which accelerations still lead to rest.

Backwards along the curve, the greatest speed from which the end can be reached; then forwards,
always as fast as that allows.

References
----------
H. Pham and Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on
Reachability Analysis", IEEE Transactions on Robotics 34(3), 2018.
"""

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
