"""Where a path turns round on itself: the joints have to rest there, and their curve has a corner.

A spline through places on one line goes out and back: between two samples the joints turn round,
as exactly as the hand does. A curve that is smooth there would cut the way's end off, and bend as
sharply as its samples are close, which no acceleration follows.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from controllers.arm.types import Joints

Array = NDArray[np.float64]

_BACK = -0.9
"""Cosine between two steps of the joints below which the second goes back."""
_SAME = 1e-12
"""Steps of the joints below which they stand, rad."""
_CLOSE = 1e-9
"""Share of the path within which two samples are one."""
_SHARPEST = 1e-13
"""Share of the path to which the place of a reversal is looked for."""
_GOLDEN = 0.5 * (3.0 - 5.0**0.5)

Samples = tuple[list[float], list[Joints]]


def with_reversals(
    nominal: list[float], joints: list[Joints], solve: Callable[[float, Joints], Joints | None]
) -> tuple[Samples, list[float]]:
    """Return samples of a joint path with one at each reversal, and the instants of these.

    Parameters
    ----------
    nominal : list of float
        Nominal time of each sample, s.
    joints : list of tuple of float
        Of each sample, rad.
    solve : callable
        From a nominal time and joints that are near to the joints there; None: not to be told.
    """
    corners = [_reversal(bracket, solve, nominal[-1]) for bracket in _brackets(nominal, joints)]
    found = [corner for corner in corners if corner is not None]
    within = _CLOSE * nominal[-1]
    kept = [
        (t, q)
        for t, q in zip(nominal, joints, strict=True)
        if all(abs(t - corner) > within for corner, _ in found)
    ]
    rows = sorted([*kept, *found], key=lambda row: row[0])
    return ([t for t, _ in rows], [q for _, q in rows]), [t for t, _ in found]


def _brackets(
    nominal: Sequence[float], joints: Sequence[Joints]
) -> list[tuple[float, float, Joints]]:
    """Return between which instants the joints turn round, with joints from there."""
    q = np.array(joints)
    moves = np.concatenate(([True], np.linalg.norm(np.diff(q, axis=0), axis=1) > _SAME))
    rows = np.flatnonzero(moves)
    steps = np.diff(q[rows], axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    turned = np.flatnonzero(_cosines(steps, 1) < _BACK)
    brackets = [(k, k + 2) for k in turned.tolist()]
    # A reversal in the middle of a step leaves of it what the hand is beside its way.
    for k in np.flatnonzero(_cosines(steps, 2) < _BACK).tolist():
        if not np.any((turned >= k - 1) & (turned <= k + 2)):
            brackets.append((k, k + 3))
    apart: list[tuple[int, int]] = []
    for bracket in sorted(brackets):  # a bend over several steps is one reversal
        if not apart or bracket[0] >= apart[-1][1]:
            apart.append(bracket)
    return [(nominal[rows[a]], nominal[rows[b]], joints[rows[a + 1]]) for a, b in apart]


def _cosines(steps: Array, apart: int) -> Array:
    """Return the cosines between unit vectors, shape (n, 6), so many rows apart."""
    return np.asarray(np.sum(steps[apart:] * steps[:-apart], axis=1), dtype=np.float64)


def _reversal(
    bracket: tuple[float, float, Joints],
    solve: Callable[[float, Joints], Joints | None],
    last: float,
) -> tuple[float, Joints] | None:
    """Return the instant between two at which the joints are farthest out, and the joints there.

    Golden section: either side of a reversal the joints go at their speed, so that it is sharp, and
    known to the last digits. SciPy's bounded search ends at 1.5e-8 of the instant.
    """
    low, high, guess = bracket
    first, last_one = solve(low, guess), solve(high, guess)
    if first is None or last_one is None:
        return None
    home = 0.5 * (np.array(first) + np.array(last_one))

    def away(t: float) -> float:
        q = solve(t, guess)
        return -1.0 if q is None else float(np.linalg.norm(np.array(q) - home))

    a, b = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
    at_a, at_b = away(a), away(b)
    while high - low > _SHARPEST * last and low < a < b < high:
        if at_a > at_b:
            high, b, at_b = b, a, at_a
            a = low + _GOLDEN * (high - low)
            at_a = away(a)
        else:
            low, a, at_a = a, b, at_b
            b = high - _GOLDEN * (high - low)
            at_b = away(b)
    t = 0.5 * (low + high)
    q = solve(t, guess)
    return None if q is None else (t, q)
