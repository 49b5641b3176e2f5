"""What strokes of a pair say once they are smoothed, and where it slides.

A controller on sticking seals never moves evenly, so velocity and acceleration are not taken by
differences: every term is weighed with one smooth bump of 20 ms, and the derivatives are moved to
the bump by parts, where they are exact.

References
----------
M. Shinbrot, "On the analysis of linear and nonlinear systems", Trans. ASME 79, 1957, pp. 547-552:
the modulating functions.
"""

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

BUMP: Final = 0.021
"""Width of the bump, s."""

_THIN: Final = 5


class Signals(NamedTuple):
    """One pair in one stretch, sample by sample or weighed with the bump.

    Parameters
    ----------
    force : ndarray, shape (n,)
        Of the pair by its chambers, N.
    position : ndarray, shape (n,)
        m; from the stretch's first sample on.
    velocity, acceleration : ndarray, shape (n,)
        m/s and m/s²; only of smoothed signals.
    load : ndarray, shape (n,)
        Sum of the pair's tensions, N.
    """

    force: "Array"
    position: "Array"
    velocity: "Array"
    acceleration: "Array"
    load: "Array"


def bump_of(period: float, length: float = BUMP) -> tuple["Array", "Array", "Array"]:
    """Return the bump of that length (s) and its two derivatives by time, for sums over samples."""
    width = max(2 * round(0.5 * length / period) + 1, 7)
    omega = 2.0 * math.pi / ((width + 1) * period)
    u = omega * period * (np.arange(width) - 0.5 * (width - 1))
    rise = 1.0 + np.cos(u)
    weight = float((rise**2).sum())
    first = -2.0 * omega * rise * np.sin(u)
    second = 2.0 * omega**2 * (np.sin(u) ** 2 - rise * np.cos(u))
    return rise**2 / weight, first / weight, second / weight


def smooth(
    force: "Array", position: "Array", load: "Array", period: float, length: float = BUMP
) -> Signals:
    """Return signals weighed with the bump of that length (s); derivatives are exact for it."""
    bump, first, second = bump_of(period, length)
    x = position - position[0]
    return Signals(
        np.correlate(force, bump, "valid"),
        np.correlate(x, bump, "valid"),
        -np.correlate(x, first, "valid"),
        np.correlate(x, second, "valid"),
        np.correlate(load, bump, "valid"),
    )


def sliding(velocity: "Array", least: float, width: int) -> "NDArray[np.int_]":
    """Return where the pair slides one way during the whole bump, thinned out."""
    from numpy.lib.stride_tricks import sliding_window_view

    half = width // 2
    if len(velocity) <= width:
        return np.zeros(0, int)
    around = sliding_window_view(velocity, width)
    inside = (around.min(axis=1) > least) | (around.max(axis=1) < -least)
    return np.flatnonzero(inside)[::_THIN] + half
