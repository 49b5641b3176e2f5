"""The plants that gains have to bear: what is told of a rig, and what may be true instead."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from rig.hal.bench import Unknown

DRAWN = 200
"""Plants whose margins are looked at."""
NOISIER = 2.0
"""Times the noise of a plant's encoders that one of the corners has: nobody measures it. With gains
that were tried without it setpoints turned round 320 times a second at 5 um instead of 1 um; with
five times the noise among the corners, gains err nearly twice as much. E"""

Numbers = dict[str, float]
"""A mechanism's model by the names of its numbers, SI."""


class Member(NamedTuple):
    """One plant of the ensemble.

    Parameters
    ----------
    name : str
        What is other in it than told; empty: nothing.
    numbers : dict of str to float
        Of its model.
    seed : int
        Of what its units are off besides.
    noisy : bool
        Whether its encoders have `NOISIER` times the noise.
    """

    name: str
    numbers: Numbers
    seed: int
    noisy: bool = False


class Plants(NamedTuple):
    """Those plants of an ensemble that gains are judged on.

    Parameters
    ----------
    corners : tuple of int
        Numbers of its corners: a motion is run there.
    drawn : tuple of int
        Numbers of its drawn plants, of whichever part: margins are measured there.
    spared : int
        So many of these count no more than the next one, those whose margins are least.
    """

    corners: tuple[int, ...]
    drawn: tuple[int, ...] = ()
    spared: int = 0


class Ensemble:
    """Plants within what is not known of a rig.

    Parameters
    ----------
    told : mapping of str to float
        Numbers of the model that the laws are told, SI.
    unknowns : sequence of Unknown
        What may be other.
    measured : iterable of str
        Keys of the mechanism's section that a calibration has replaced.
    seed : int
        Of the units.
    """

    def __init__(
        self,
        told: Mapping[str, float],
        unknowns: Sequence[Unknown],
        measured: Iterable[str],
        seed: int,
    ) -> None:
        self._told, self._unknowns, self._seed = dict(told), tuple(unknowns), seed
        known = set(measured)
        self.bounds = {
            unknown.name: unknown.measured if unknown.measured_by in known else unknown.guessed
            for unknown in unknowns
        }
        """Of each unknown, as its `Unknown.unit` says."""

    def ranges(self) -> dict[str, str]:
        """Return the bounds of each unknown in words: factors, or quantities with their unit."""
        return {
            unknown.name: " to ".join(_amount(unknown, end) for end in self.bounds[unknown.name])
            for unknown in self._unknowns
        }

    @property
    def nominal(self) -> Member:
        """The plant that is as told."""
        return Member("", dict(self._told), self._seed)

    def corners(self) -> list[Member]:
        """Return every combination of least, told and greatest, and the told plant with noise.

        The nominal plant is the first, that with noisy encoders the last.
        """
        levels = []
        for unknown in self._unknowns:
            low, high = self.bounds[unknown.name]
            levels.append((0.0 if unknown.unit else 1.0, low, high))
        found = [self._member(values, self._seed + k) for k, values in enumerate(product(*levels))]
        noisy = Member(f"encoder noise x {NOISIER:g}", dict(self._told), self._seed, noisy=True)
        return [self.nominal, *found[1:], noisy]

    def first(self) -> tuple[int, ...]:
        """Return the numbers of the corners that stand for all at first.

        The nominal plant, that with noisy encoders, and half of those where everything is least or
        greatest: of any two unknowns every combination is among them.
        """
        levels = list(product(range(3), repeat=len(self._unknowns)))
        extreme = [
            number for number, level in enumerate(levels)
            if 0 not in level and level.count(2) % 2 == 1
        ]  # fmt: skip
        return (0, *extreme, len(levels))

    def near(self) -> list[Member]:
        """Return the told plant, and those at the ends of what a calibration would leave open.

        A linear model says how far their loops are from instability. It leaves Coulomb friction
        out, which holds a loop on plants that are farther off; there trials have the word.
        """
        ends = product(*(unknown.measured for unknown in self._unknowns))
        return [self.nominal, *(self._member(values, self._seed) for values in ends)]

    def draw(self, count: int = DRAWN, part: int = 0) -> list[Member]:
        """Return plants within what a calibration would leave open, from the ensemble's seed.

        Parameters
        ----------
        count : int
            So many.
        part : int
            No plant of another part is among them: a search has parts of its own, and the verdict
            the first, so that no gains are judged on the plants that they were found on.
        """
        rng = np.random.default_rng([self._seed, count, *([part] if part else [])])
        lows, highs = np.array([unknown.measured for unknown in self._unknowns]).T
        values = rng.uniform(lows, highs, (count, len(self._unknowns)))
        units = self._seed + 1000 * (1 + part)
        return [self._member(row, units + k) for k, row in enumerate(values.tolist())]

    def drawn(self, number: int) -> Member:
        """Return a drawn plant by its number among those of all parts."""
        return self.draw(part=number // DRAWN)[number % DRAWN]

    def _member(self, values: Iterable[float], seed: int) -> Member:
        numbers, words = dict(self._told), []
        for unknown, value in zip(self._unknowns, values, strict=True):
            for name in unknown.numbers:
                one = numbers[name]
                numbers[name] = max(one + value, 0.0) if unknown.unit else one * value
            if value != (0.0 if unknown.unit else 1.0):
                words.append(f"{unknown.name} {_amount(unknown, value)}")
        return Member(", ".join(words), numbers, seed)


def _amount(unknown: Unknown, value: float) -> str:
    if unknown.unit == "s":
        return f"{value * 1e3:+.3g} ms"
    return f"{value:+.3g} {unknown.unit}" if unknown.unit else f"x {value:.3g}"
