"""Find rods that have run off their references by themselves, and were not left behind."""

from collections.abc import Callable


class RunsOff:
    """Tells which rods are farther off than any that lags, by their own motion.

    Parameters
    ----------
    count : int
        How many rods there are.
    most : float
        How far one may be off so, m.
    """

    def __init__(self, count: int, most: float) -> None:
        self.most = most
        self._near = 0.5 * most
        self._left_at: list[float | None] = [None] * count
        """Where each was last near enough, m."""
        self._driven: set[int] = set()
        """Which of them were found to have been driven off since then."""

    def has_run(
        self, k: int, error: float, place: float, driven: Callable[[int, float], bool]
    ) -> bool:
        """Take where rod `k` is, and how far off its reference, m; return whether it has run there.

        Parameters
        ----------
        driven : callable
            See `TrackingWatch.check`.
        """
        near = self._near
        left_at = self._left_at[k]
        if -near <= error <= near or left_at is None:
            self._left_at[k] = place
            self._driven.discard(k)
            return False
        way = place - left_at if error > 0.0 else left_at - place
        if abs(error) <= self.most or way <= near or k in self._driven:
            return False
        if driven(k, error):
            self._driven.add(k)
            return False
        return True
