"""The rods' ways of late: which of them gained most for its pull when the last run began."""

import itertools
from collections import deque
from collections.abc import Sequence

from controllers.spherical_joint.geometry import Quadruple

_CYCLES = 512
"""So many are remembered: a wire lets go within a few, between two checks."""
_BEGINS = 0.1
"""A run begins when one of the rods that are compared exceeds this speed, m/s …"""
_FIRST = 3
"""… and shows in so many cycles which one leads: where a wire is cut, its rod moves itself
alone, and the opposite one the ring as well."""
_LEAST_PULL = 1e3
"""A chamber that does not move its rod counts as if this much of its pressure (Pa) did."""
_CLEARLY = 1.5
"""A rod leads if it gained so many times as much as the next one: 2 and more where its wire was
cut near upright, and 1.3 may be either's …"""
_LEAST_WAY = 0.25e-3
"""… and went so far (m): where chambers fill, it is less, and either may be the first to slip."""


class RodRuns:
    """Remembers the rods of each cycle.

    Parameters
    ----------
    idle_pull : float
        Below this pressure (Pa gauge) a chamber may be too weak to move its rod.
    """

    def __init__(self, idle_pull: float) -> None:
        self._idle_pull = idle_pull
        self._cycles: deque[tuple[float, Quadruple]] = deque(maxlen=_CYCLES)

    def follow(self, rods: Quadruple, now: float) -> None:
        """Take the rods of a cycle, m, inwards positive."""
        self._cycles.append((now, rods))

    def leader(self, among: Sequence[int], pressures: Quadruple) -> int | None:
        """Return which of some rods gained most for its pull in the last run; None: no one clearly.

        Speeds alone do not tell: the rod whose chamber has more pressure is soon the faster one.

        Parameters
        ----------
        among : sequence of int
            The rods, 0 … 3.
        pressures : tuple of float
            Of all four chambers, Pa gauge.
        """
        ways = self._ways(among)
        pulls = [max(pressures[k] - self._idle_pull, _LEAST_PULL) for k in among]
        gains = [way / pull for way, pull in zip(ways, pulls, strict=True)]
        first, second = sorted(range(len(among)), key=lambda n: -gains[n])[:2]
        leads = gains[first] > _CLEARLY * max(gains[second], 0.0)
        return among[first] if leads and ways[first] > _LEAST_WAY else None

    def _ways(self, among: Sequence[int]) -> list[float]:
        """Return how far rods went when the last run began, m; 0: none ran."""
        steps = [
            (t - then, [rods[i] - before[i] for i in among])
            for (then, before), (t, rods) in itertools.pairwise(self._cycles)
        ]

        def runs(step: tuple[float, list[float]]) -> bool:
            return max(step[1]) > _BEGINS * step[0]

        began = len(steps)
        while began and not runs(steps[began - 1]):  # a wire that was slack is taut again
            began -= 1
        if not began:
            return [0.0] * len(among)
        while began and runs(steps[began - 1]):
            began -= 1
        before = max(began - 2, 0)  # the run may have begun within the cycle after this one
        usual = steps[before][1] if began else [0.0] * len(among)
        first = steps[before : began + _FIRST]
        return [sum(way[n] - usual[n] for _, way in first) for n in range(len(among))]
