"""How far pressures have gone of late, beside those of healthy regulators."""

import math
from collections import deque
from collections.abc import Sequence


class PressureWays:
    """The last stretch of pressures, as they were shown and as they should have been.

    Parameters
    ----------
    length : float
        How much of the past it holds, s.
    """

    def __init__(self, length: float) -> None:
        self._length = length
        self._past: deque[tuple[float, Sequence[float], Sequence[float]]] = deque()

    def clear(self) -> None:
        """Forget the past."""
        self._past.clear()

    def note(self, now: float, shown: Sequence[float], healthy: Sequence[float]) -> None:
        """Take the pressures of a cycle, Pa."""
        past = self._past
        past.append((now, shown, healthy))
        while now - past[0][0] > self._length:
            past.popleft()

    def share_gone(self, k: int, least: float) -> float:
        """Return how far one pressure has gone, over a healthy one's way; 0: it was held.

        Both rms about their means, so that neither an offset nor a delay changes it.

        Parameters
        ----------
        k : int
            Which pressure.
        least : float
            So far must a healthy one have gone, Pa; nan if it did not.
        """
        healthy = _rms([row[k] for _, _, row in self._past])
        return _rms([row[k] for _, row, _ in self._past]) / healthy if healthy > least else math.nan

    def follows(self, k: int, least: float) -> float:
        """Return how much one pressure changes with a healthy one, over the healthy one's change.

        1: it follows; 0: it stays, or goes its own way, however far. Parameters as `share_gone`.
        """
        shown = [row[k] for _, row, _ in self._past]
        healthy = [row[k] for _, _, row in self._past]
        size = _rms(healthy)
        if not size > least:
            return math.nan
        middle = sum(healthy) / len(healthy)
        along = sum(one * (other - middle) for one, other in zip(shown, healthy, strict=True))
        return along / (len(healthy) * size * size)

    def beyond(self, k: int) -> float:
        """Return how far one pressure is now above or below all that a healthy one had, Pa, or 0.

        One that comes late is where a healthy one has been.
        """
        healthy = [row[k] for _, _, row in self._past]
        now = self._past[-1][1][k]
        return max(now - max(healthy), min(healthy) - now, 0.0)


def _rms(values: list[float]) -> float:
    middle = sum(values) / len(values)
    return math.sqrt(sum((value - middle) ** 2 for value in values) / len(values))
