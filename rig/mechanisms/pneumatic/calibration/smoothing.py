"""The force and position of an antagonistic pair, smoothed, with derivatives.

A controller on sticking seals never moves evenly, so velocity and acceleration are not taken by
differences. Every term is weighed with one smooth bump instead, by default 21 ms wide, and the
derivatives are moved to the bump by parts, where they are exact.

References
----------
M. Shinbrot, "On the analysis of linear and nonlinear systems", Trans. ASME 79, 1957, pp. 547-552:
the modulating functions.
"""

import math
from typing import Final, NamedTuple

import numpy as np

from rig.calibration.arrays import Array, Indices

_THIN: Final = 5
"""Neighbouring samples say the same: every so many of them is used."""


class PairSignals(NamedTuple):
    """One pair in one stretch, sample by sample.

    Parameters
    ----------
    name : str
        Of the pair; empty if there is but one.
    force : ndarray, shape (n,)
        That the chambers put into moving the pair, N.
    position : ndarray, shape (n,)
        m.
    load : ndarray, shape (n,)
        Sum of the two tensions, N.
    """

    name: str
    force: Array
    position: Array
    load: Array


class SmoothSignals(NamedTuple):
    """One pair in one stretch, weighed with a bump.

    Parameters
    ----------
    force : ndarray, shape (n,)
        Of the pair by its chambers, N.
    position : ndarray, shape (n,)
        m; from the stretch's first sample on.
    velocity, acceleration : ndarray, shape (n,)
        m/s and m/s².
    load : ndarray, shape (n,)
        Sum of the pair's tensions, N.
    """

    force: Array
    position: Array
    velocity: Array
    acceleration: Array
    load: Array


class Bump:
    """A bump (1 + cos)² that samples are weighed with.

    Parameters
    ----------
    period : float
        Of the samples, s.
    length : float
        Of the bump, s.
    """

    def __init__(self, period: float, length: float = 0.021) -> None:
        self.width = max(2 * round(0.5 * length / period) + 1, 7)
        """How many samples it covers."""
        omega = 2.0 * math.pi / ((self.width + 1) * period)
        u = omega * period * (np.arange(self.width) - 0.5 * (self.width - 1))
        rise = 1.0 + np.cos(u)
        weight = float((rise**2).sum())
        self._weights = rise**2 / weight
        self._first = 2.0 * omega * rise * np.sin(u) / weight
        self._second = 2.0 * omega**2 * (np.sin(u) ** 2 - rise * np.cos(u)) / weight

    def mean(self, samples: Array) -> Array:
        """Return the weighed mean around each sample that has enough neighbours."""
        return np.correlate(samples, self._weights, "valid")

    def rate(self, samples: Array) -> Array:
        """Return the derivative by time of the weighed mean."""
        return np.correlate(samples, self._first, "valid")

    def smooth(self, pair: PairSignals) -> SmoothSignals:
        """Return a pair's signals weighed; derivatives are exact for them."""
        x = pair.position - pair.position[0]
        return SmoothSignals(
            self.mean(pair.force), self.mean(x), self.rate(x),
            np.correlate(x, self._second, "valid"), self.mean(pair.load),
        )  # fmt: skip

    def sliding(self, velocity: Array, least: float) -> Indices:
        """Return where a pair slides one way during the whole bump, thinned out.

        Parameters
        ----------
        velocity : ndarray, shape (n,)
            Smoothed, m/s.
        least : float
            Speed that it keeps above, m/s.
        """
        from numpy.lib.stride_tricks import sliding_window_view

        if len(velocity) <= self.width:
            return np.zeros(0, int)
        around = sliding_window_view(velocity, self.width)
        inside = (around.min(axis=1) > least) | (around.max(axis=1) < -least)
        return np.flatnonzero(inside)[::_THIN] + self.width // 2
