"""How far a loop is from instability, as it was measured on a rig."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rig.hal.closed_loop import ClosedLoop
from rig.hal.errors import ConfigurationError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_FEWEST = 3
"""Frequencies between which anything can be told."""
_LOST = 0.5
"""Share of what was drawn in which a margin may be unknown."""
_POINTS = 2000
"""Frequencies between the least and the greatest that were measured."""


class LoopUntold(ConfigurationError):
    """A recording of a run that was as it should be does not tell its loop: noise hides it."""


class MeasuredLoop(NamedTuple):
    """The loop that a law closes around a rig, at the frequencies with which it was shaken.

    Parameters
    ----------
    frequencies : ndarray, shape (n,)
        Hz, ascending.
    response : ndarray of complex, shape (n,)
        Of the open loop; -1 is the critical point.
    drawn : ndarray of complex, shape (m, n)
        The same of resampled glides: how well it is known.
    model : ndarray of complex, shape (n,)
        What the profile's linear model says.
    shaken : ndarray, optional
        All frequencies of the shake, Hz; None: those that are known.
    """

    frequencies: Array
    response: Complex
    drawn: Complex
    model: Complex
    shaken: Array | None = None

    def known(self, scatter: float) -> "MeasuredLoop":
        """Return the loop from the first frequency at which it is known to the last of that range.

        Parameters
        ----------
        scatter : float
            Greatest root mean square of what was drawn from the response, as a share of that.

        Raises
        ------
        ValueError
            It is known nowhere, or at too few frequencies.
        """
        off = np.sqrt(np.mean(np.abs(self.drawn - self.response) ** 2, axis=0))
        is_known = off <= scatter * np.abs(self.response)
        first = int(np.argmax(is_known))
        unknown = np.flatnonzero(~is_known[first:])
        last = first + int(unknown[0]) if len(unknown) else len(off)
        if not is_known[first] or last - first < _FEWEST:
            raise ValueError("the loop cannot be told from noise")
        part = slice(first, last)
        return MeasuredLoop(
            self.frequencies[part], self.response[part], self.drawn[:, part], self.model[part],
            self.frequencies,
        )  # fmt: skip

    @property
    def margins(self) -> ClosedLoop:
        """The loop's distance from instability, as far as it was measured."""
        return margins_of(self.frequencies, self.response)

    @property
    def tells_crossover(self) -> bool:
        """Whether it is known where its gain is 1; else it may be less stable than it looks."""
        return not math.isnan(self.margins.crossover)

    @property
    def is_partial(self) -> bool:
        """Whether less than half of the shake's frequencies tell anything.

        What is known then may be of a pair that catches: nearer to instability than one that
        glides, or farther from it.
        """
        return self.shaken is not None and 2 * len(self.frequencies) < len(self.shaken)

    def interval(self, name: str) -> tuple[float, float]:
        """Return the 95 % interval of one of the `margins`; NaN where that is not known."""
        found = [getattr(margins_of(self.frequencies, one), name) for one in self.drawn]
        if math.isnan(getattr(self.margins, name)) or np.mean(np.isnan(found)) > _LOST:
            return math.nan, math.nan
        found = [value for value in found if not math.isnan(value)]
        low, high = np.percentile(found, (2.5, 97.5), method="nearest")
        return float(low), float(high)


def margins_of(frequencies: Array, response: Complex) -> ClosedLoop:
    """Return the margins of an open loop that is known at some frequencies.

    Between them its logarithm is a straight line over that of the frequency. That the loop is
    stable shows in that it ran. Where its gain is 1 outside of them, crossover, phase and delay
    are NaN: nobody knows them.

    Parameters
    ----------
    frequencies : ndarray, shape (n,)
        Hz, ascending.
    response : ndarray of complex, shape (n,)
        Of the open loop.
    """
    at = np.log(frequencies)
    fine = np.linspace(at[0], at[-1], _POINTS)
    gain = np.interp(fine, at, np.log(np.abs(response)))
    phase = np.interp(fine, at, np.unwrap(np.angle(response)))
    sensitivity = float(np.max(1.0 / np.abs(1.0 + np.exp(gain + 1j * phase))))
    crossings = np.flatnonzero(gain[:-1] * gain[1:] < 0.0)
    if not len(crossings):
        return ClosedLoop(True, math.nan, math.nan, math.nan, sensitivity)
    w = 2.0 * math.pi * np.exp(fine[crossings])
    left = np.angle(-np.exp(1j * phase[crossings]))
    delay = np.mod(left, 2.0 * math.pi) / w
    return ClosedLoop(True, float(w[-1]), float(np.min(np.abs(left))), float(delay.min()),
                      sensitivity)  # fmt: skip
