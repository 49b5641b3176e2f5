"""A pair as a shake shows it: what a law reads of it over what the law sends.

Position and difference of the pressures over the difference of the setpoints are the pair, whatever
shakes it, as the shake is none of its noise. Around it a law is known to rounding: it is a program.

References
----------
L. Ljung, "System identification", 2nd ed., 1999, section 13.5: joint input-output identification
of what is under control.
"""

import math
from collections.abc import Iterable
from typing import Final

import numpy as np

from controllers.cylinder.law import AnyPairLaw
from controllers.cylinder.margins import measured_loop, modelled_loop
from rig.hal.closed_loop import ClosedLoop
from rig.hal.measured_loop import Array, Complex, MeasuredLoop

FEWEST: Final = 6
"""Glides from which an interval can be told."""
_DRAWN: Final = 200
"""So often glides are drawn anew."""
_SCATTER: Final = 0.5
"""Of a response, beside it: where it is larger, nothing is told."""
UNTOLD: Final = ClosedLoop(True, math.nan, math.nan, 0.0, math.inf)
"""The loop of a pair that is lost, sticks, or swings by itself while it is shaken."""


class ShakenPair:
    """A pair as `ShakenGlides` show it.

    Parameters
    ----------
    frequencies : ndarray, shape (k,)
        Of the shake, Hz.
    glides : iterable of (ndarray, ndarray)
        Of each the times since the shake's period began (s), and what was sent and read then,
        shape (n, 3): difference of the setpoints (Pa), position (m), difference of the pressures
        (Pa).

    Raises
    ------
    ValueError
        They are too few.
    """

    def __init__(self, frequencies: Array, glides: Iterable[tuple[Array, Array]]) -> None:
        self.frequencies = frequencies
        parts: list[Complex] = []
        before, told = np.empty(0), np.empty(0, complex)
        for t, signals in glides:
            if not np.array_equal(t, before):
                before, told = t, _teller(t, self.frequencies)
            parts.append(np.asarray(told @ signals))
        if len(parts) < FEWEST:
            raise ValueError(f"{len(parts)} whole glides, and {FEWEST} are needed to tell a loop")
        self._parts: Complex = np.array(parts)

    def under(self, law: "ShakenLaw") -> MeasuredLoop:
        """Return the loop that a law closes around this pair.

        Raises
        ------
        ValueError
            Noise hides it.
        """
        generator = np.random.default_rng(0)
        count = len(self._parts)
        drawn = [
            law.around(self._parts[generator.integers(0, count, count)]) for _ in range(_DRAWN)
        ]
        found = MeasuredLoop(
            self.frequencies, law.around(self._parts), np.array(drawn), law.modelled
        )
        return found.known(_SCATTER)


def shaken_margins(
    glides: Iterable[tuple[Array, Array]], frequencies: Array, law: "ShakenLaw"
) -> ClosedLoop:
    """Return the margins of a loop; `UNTOLD` if glides do not tell it where its gain is 1.

    Parameters
    ----------
    glides, frequencies
        See `ShakenPair`.
    law : ShakenLaw
        What closes it.
    """
    try:
        loop = ShakenPair(frequencies, glides).under(law)
    except ValueError:
        return UNTOLD
    return loop.margins if loop.tells_crossover else UNTOLD


class ShakenLaw:
    """The linear part of a law, at the frequencies of a shake.

    Parameters
    ----------
    law : PairLaw
        It is not changed, and need not be the one that ran.
    frequencies : ndarray, shape (k,)
        Hz.
    """

    def __init__(self, law: AnyPairLaw, frequencies: Array) -> None:
        f = frequencies
        one, none = np.ones(len(f), complex), np.zeros(len(f), complex)
        self._by_position = measured_loop(law, f, np.column_stack([one, none]))
        self._by_pressure = measured_loop(law, f, np.column_stack([none, one]))
        self.modelled = modelled_loop(law, law.model, f)
        """The loop around a pair that is as the law is told."""

    def around(self, glides: Complex) -> Complex:
        """Return the response of the open loop from the phasors of some glides."""
        sent, came, pressed = _midmean(glides).T
        return np.asarray((self._by_position * came + self._by_pressure * pressed) / sent)


def _midmean(glides: Complex) -> Complex:
    """Return the mean of the middle half of all glides, of each real and imaginary part.

    A glide in which the seals catch for an instant says nothing of what is linear, and its part
    may be many times as large as that of the others.
    """
    count = len(glides)
    middle = slice(count // 4, count - count // 4)
    parts = [np.sort(part, axis=0)[middle].mean(axis=0) for part in (glides.real, glides.imag)]
    return np.asarray(parts[0] + 1j * parts[1])


def _teller(t: Array, frequencies: Array) -> Complex:
    """Return the matrix that tells the part of a signal at each frequency, beside a straight line.

    By least squares; times in s, frequencies in Hz.
    """
    angles = 2.0 * np.pi * np.outer(t, frequencies)
    basis = np.column_stack([np.ones_like(t), t, np.cos(angles), np.sin(angles)])
    found = np.linalg.pinv(basis)[2:]
    count = len(frequencies)
    return np.asarray(found[:count] - 1j * found[count:])
