"""Which SYNC a transmit PDO answers, although answers may be lost or late.

A PDO does not say it, and the phase at which it comes shows only what is left of a delay beside
whole cycles. So one SYNC is left out when answers were missing and come again: the gap that it
leaves among them comes as many cycles later as they are late, and at once if they were lost.
"""

from typing import Final

_KEPT: Final = 64
"""SYNCs whose times are kept: a reading that is older is stale on every rig."""
_PAUSE: Final = 50
"""Fewest cycles between two SYNCs that are left out."""


class SyncTrain:
    """The SYNCs of a bus: one each cycle, but for those left out to learn how late answers are.

    Attributes
    ----------
    count : int
        Cycles so far.
    time : float
        When the last SYNC was sent, s.
    omitted : int
        Number of the last cycle without a SYNC.
    omissions : int
        How many there were.
    can_omit : bool
        False if another device sends SYNC: then answers that come again are taken for punctual.
    """

    __slots__ = (
        "_settled", "_times", "can_omit", "count", "omissions", "omitted", "time", "wanted",
    )  # fmt: skip

    def __init__(self, *, can_omit: bool) -> None:
        self.count = 0
        self.time = float("-inf")
        self.omitted = -_PAUSE
        self.omissions = 0
        self.can_omit = can_omit
        self.wanted = False
        self._settled = 0
        self._times = [self.time] * _KEPT

    def send(self, t: float) -> None:
        """Count a SYNC that was sent. Hot path."""
        self.count += 1
        self.time = self._times[self.count % _KEPT] = t

    def leave_out(self) -> None:
        """Count a cycle without one."""
        self.wanted = False
        self.count += 1
        self.omissions += 1
        self.omitted = self.count
        self._times[self.count % _KEPT] = self.time

    def settle(self) -> None:
        """Expect disorder for another two cycles: nodes are being started."""
        self.wanted = False
        self._settled = self.count + 2

    def doubt(self) -> None:
        """Have the next SYNC left out, unless one was a short time ago."""
        if self.can_omit and self.count > self._settled and self.count >= self.omitted + _PAUSE:
            self.wanted = True

    def time_of(self, lag: int) -> float:
        """Return when the SYNC was sent that is so many cycles older than the last one, s."""
        return self._times[(self.count - lag) % _KEPT] if lag < _KEPT else float("-inf")


class Answers:
    """The answers that one transmit PDO gives to SYNC.

    Attributes
    ----------
    lag : int
        How many cycles older the SYNC is that the last one answered, as far as is known.
    late : int
        Answers that came in another cycle than that of their SYNC.
    """

    __slots__ = ("_last", "_omitted", "_syncs", "lag", "late")

    def __init__(self, syncs: SyncTrain) -> None:
        self._syncs = syncs
        self.late = 0
        self.arm()

    def arm(self) -> None:
        """Expect answers from now on."""
        self._last = self._syncs.count
        self._omitted = self._syncs.omitted
        self.lag = 0

    def take(self) -> float:
        """Count one; return when the SYNC was sent that it answers, s. Hot path."""
        syncs = self._syncs
        count = syncs.count
        if count - self._last != 1 or syncs.omitted != self._omitted:
            self._judge(count)
        self._last = count
        if not self.lag:
            return syncs.time
        self.late += 1
        return syncs.time_of(self.lag)

    def _judge(self, count: int) -> None:
        """Learn the lag from an irregular answer, or have a SYNC left out for the next ones."""
        syncs, silent_from = self._syncs, self._last + 1
        omitted, is_gap = syncs.omitted, count > silent_from
        if omitted != self._omitted and count > omitted and is_gap:
            self.lag = max(silent_from, omitted) - omitted
            self._omitted = omitted
            is_gap = count > silent_from + 1  # more is missing than was left out
        elif omitted != self._omitted and count >= omitted:
            self.lag = max(self.lag, count - omitted + 1)  # an answer where a punctual one is none
        came_twice = count < silent_from and self.lag > 0  # it may have caught up
        if is_gap or came_twice:
            syncs.doubt()
