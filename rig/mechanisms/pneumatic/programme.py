"""The motions of a trial one after the other, and what of them is judged."""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from rig.hal.motion import Motion

Array = NDArray[np.float64]
Followed = TypeVar("Followed")

_APPROACH: Final = 1.0
"""Between two motions, s."""
_JUMP: Final = 1e-3
"""A reference that moves farther within a cycle jumps, m or in unit vectors."""


class Programme(NamedTuple):
    """References of every cycle, and the stretches that are judged.

    Parameters
    ----------
    references : ndarray, shape (n, 3 d)
        Position, velocity and acceleration, of d numbers each, SI.
    stretches : tuple
        Name, first cycle and the one after the last.
    """

    references: Array
    stretches: tuple[tuple[str, int, int], ...]

    @classmethod
    def of(
        cls,
        motions: Sequence[Motion[Followed]],
        period: float,
        home: Followed,
        approach: Callable[[Followed, Followed, float, float], Followed],
        row: Callable[[Followed], Sequence[float]],
    ) -> "Programme":
        """Return the programme of some motions, each approached from where the last one ended.

        Parameters
        ----------
        motions : sequence of Motion
            From rest to rest.
        period : float
            s.
        home : object
            The reference from which the first one is approached.
        approach : callable
            Of the mechanism: the reference after some seconds of a way between two.
        row : callable
            Returns the numbers of a reference.
        """
        here = home
        rows: list[Sequence[float]] = []
        stretches: list[tuple[str, int, int]] = []
        for motion in motions:
            start = motion.at(0.0)
            cycles = round(_APPROACH / period)
            rows += [row(approach(here, start, _APPROACH, k * period)) for k in range(cycles)]
            first = len(rows)
            cycles = round(motion.duration / period)
            rows += [row(motion.at(k * period)) for k in range(cycles)]
            stretches += [
                (name, first + round(begin / period), first + round(end / period))
                for name, begin, end in motion.segments
            ]
            here = motion.at(motion.duration)
        return cls(np.array(rows), tuple(stretches))

    def rests(self, first: int, end: int) -> bool:
        """Return whether the reference rests over some cycles."""
        places = self.references.shape[1] // 3
        return not np.any(self.references[first:end, places:])

    def jumps(self, first: int) -> bool:
        """Return whether the reference stands somewhere else in a cycle than it did before."""
        places = self.references.shape[1] // 3
        here, before = self.references[first, :places], self.references[max(first - 1, 0), :places]
        return bool(np.any(np.abs(here - before) > _JUMP))

    def rms(self, errors: Array) -> dict[str, float]:
        """Return the rms error of each stretch that moves, of all holds, and of all steps.

        Parameters
        ----------
        errors : ndarray, shape (n, d)
            Of each cycle.
        """
        squares: dict[str, list[Array]] = {}
        for name, first, end in self.stretches:
            key = "step" if name.startswith("step ") else name  # one with a rise is one, too
            if self.rests(first, end):
                key = "step" if self.jumps(first) else "hold"
            squares.setdefault(key, []).append(np.sum(errors[first:end] ** 2, axis=1))
        return {
            name: float(np.sqrt(np.mean(np.concatenate(parts)))) for name, parts in squares.items()
        }

    def hunting(self, errors: Array) -> float:
        """Return the greatest peak-to-peak motion along an axis in the second half of a hold."""
        holds = [errors[(a + b) // 2 : b] for _, a, b in self.stretches if self.rests(a, b)]
        return max((float(np.max(np.ptp(hold, axis=0))) for hold in holds), default=0.0)


def lasting_error(errors: Array, cycles: int) -> float:
    """Return the greatest error (m) that is reached or passed for so many cycles in a row."""
    from scipy.ndimage import minimum_filter1d

    sizes = np.abs(errors)
    if len(sizes) < cycles:
        return 0.0
    whole = minimum_filter1d(sizes, cycles)[cycles // 2 : len(sizes) - (cycles - 1) // 2]
    return float(np.max(whole))
