"""What regulators answer by now: the setpoints of a dead time ago."""

from collections import deque
from collections.abc import Sequence


class DeadTimeLine:
    """Setpoints on their way through a dead time.

    Parameters
    ----------
    dead_time : float
        s, at least 0.
    """

    def __init__(self, dead_time: float) -> None:
        self._dead_time = dead_time
        self._sent: deque[tuple[float, Sequence[float]]] = deque()

    def clear(self) -> None:
        """Forget what was sent, as after a pause."""
        self._sent.clear()

    def pass_on(self, setpoints: Sequence[float], now: float) -> Sequence[float]:
        """Take the setpoints that act from now on but for the dead time; return those that do.

        While none is old enough these are the first that were taken.
        """
        sent, latest = self._sent, now - self._dead_time
        sent.append((now, setpoints))
        while len(sent) > 1 and sent[1][0] <= latest:
            sent.popleft()
        return sent[0][1]
