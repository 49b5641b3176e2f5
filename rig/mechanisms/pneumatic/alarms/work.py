"""Tell opposite encoders that are swapped by the work that the pressures seem to do."""

from collections import deque
from collections.abc import Callable, Sequence

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.alarms.settings import SwappedAlarm

Pair = tuple[int, int]

_STEP = 20e-6
"""Ways shorter than this (m) are not added: encoder noise is no motion."""


class WorkWatch:
    """Adds up the work of each pair's differential pull until the pair has passed.

    Parameters
    ----------
    settings : SwappedAlarm
        Over what way, and how much.
    area : float
        Effective piston area, m².
    coulomb : float
        Friction of a pair while it slides, N.
    encoders : sequence of str
        Their names in the order of the channels.
    channels : sequence of str
        For messages.
    pairs : sequence of tuple of int
        Agonist and antagonist of each pair.
    """

    def __init__(
        self,
        settings: SwappedAlarm,
        area: float,
        coulomb: float,
        encoders: Sequence[str],
        channels: Sequence[str],
        pairs: Sequence[Pair],
    ) -> None:
        self._distance = settings.distance
        self._area = area
        self._bound = settings.share * coulomb
        self._encoders = tuple(encoders)
        self._channels = tuple(channels)
        self._open = dict.fromkeys(pairs) if self._bound > 0.0 else {}
        self._from: dict[Pair, float] = {}
        self._steps: dict[Pair, deque[tuple[float, float]]] = {pair: deque() for pair in pairs}

    def check(
        self,
        rods: Sequence[float],
        pressures: Sequence[float],
        explain: Callable[[], str | None],
    ) -> None:
        """Take readings and raise if a pair has moved against its own pull.

        Parameters
        ----------
        rods, pressures : tuple of float
            m and Pa gauge.
        explain : callable
            Returns a swap that is not one of opposite encoders, if there is one: it makes
            pairs move against their pull too.

        Raises
        ------
        SafetyError
            It has.
        """
        for pair in tuple(self._open):
            agonist, antagonist = pair
            place = 0.5 * (rods[agonist] - rods[antagonist])
            way = place - self._from.setdefault(pair, place)
            if abs(way) < _STEP:
                continue
            self._from[pair] = place
            steps = self._steps[pair]
            pull = self._area * (pressures[agonist] - pressures[antagonist])
            steps.append((abs(way), pull * way))
            covered = sum(length for length, _ in steps)
            while covered - steps[0][0] >= self._distance:
                covered -= steps.popleft()[0]
            if covered < self._distance:
                continue
            work = sum(done for _, done in steps)
            bound = self._bound * covered  # the last step may reach beyond the distance
            if work > bound:
                del self._open[pair]
            elif work < -bound:
                cause = explain() or self._explain(pair)
                raise SafetyError(
                    f"{cause}: the rods move against their pull, or are pushed "
                    f"[work {work * 1e3:.1f} mJ over {covered * 1e3:.2f} mm, at least "
                    f"{-bound * 1e3:.1f} mJ]"
                )

    def _explain(self, pair: Pair) -> str:
        one, other = sorted(pair)
        return (
            f"{self._encoders[one]} and {self._encoders[other]} are swapped, or the tubes of "
            f"{self._channels[one]} and {self._channels[other]}, or one of these tubes is off"
        )
