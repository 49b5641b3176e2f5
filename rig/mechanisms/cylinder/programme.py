"""The motions of a trial one after the other, and what of them is judged."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.cylinder.types import PairReference
from controllers.minimum_jerk import minimum_jerk
from rig.mechanisms.cylinder.references import PairMotion

Array = NDArray[np.float64]

_APPROACH: Final = 1.0
"""Between two motions, s."""


class Programme(NamedTuple):
    """References of every cycle, and the stretches that are judged.

    Parameters
    ----------
    references : ndarray, shape (n, 3)
        Position (m), velocity and acceleration.
    stretches : tuple
        Name, first cycle and the one after the last.
    """

    references: Array
    stretches: tuple[tuple[str, int, int], ...]

    @classmethod
    def of(cls, motions: Sequence[PairMotion], period: float) -> "Programme":
        """Return the programme of some motions, each approached from where the last one ended.

        Parameters
        ----------
        motions : sequence of PairMotion
            From rest to rest.
        period : float
            s.
        """
        here = PairReference(0.0, 0.0, 0.0)
        rows: list[PairReference] = []
        stretches: list[tuple[str, int, int]] = []
        for motion in motions:
            start = motion.at(0.0)
            cycles = round(_APPROACH / period)
            rows += [
                PairReference(*minimum_jerk(here.position, start.position, _APPROACH, k * period))
                for k in range(cycles)
            ]
            first = len(rows)
            cycles = round(motion.duration / period)
            rows += [motion.at(k * period) for k in range(cycles)]
            stretches += [
                (name, first + round(begin / period), first + round(end / period))
                for name, begin, end in motion.segments
            ]
            here = motion.at(motion.duration)
        return cls(np.array(rows), tuple(stretches))

    def rests(self, first: int, end: int) -> bool:
        """Return whether the reference rests over some cycles."""
        return not np.any(self.references[first:end, 1:])

    def rms(self, errors: Array) -> dict[str, float]:
        """Return the rms error of each stretch that moves, and of all holds together."""
        squares: dict[str, list[Array]] = {}
        for name, first, end in self.stretches:
            key = "hold" if self.rests(first, end) else name
            squares.setdefault(key, []).append(errors[first:end] ** 2)
        return {
            name: float(np.sqrt(np.mean(np.concatenate(parts)))) for name, parts in squares.items()
        }

    def hunting(self, errors: Array) -> float:
        """Return the greatest peak-to-peak motion in the second half of a hold, m."""
        holds = [errors[(a + b) // 2 : b] for _, a, b in self.stretches if self.rests(a, b)]
        return max((float(np.ptp(hold)) for hold in holds), default=0.0)


def lasting_error(errors: Array, cycles: int) -> float:
    """Return the greatest error (m) that is reached or passed for so many cycles in a row."""
    from scipy.ndimage import minimum_filter1d

    sizes = np.abs(errors)
    if len(sizes) < cycles:
        return 0.0
    whole = minimum_filter1d(sizes, cycles)[cycles // 2 : len(sizes) - (cycles - 1) // 2]
    return float(np.max(whole))
