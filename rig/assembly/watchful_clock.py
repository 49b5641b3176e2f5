"""The clock by which buses and devices wait: what must not be forgotten meanwhile is looked at."""

from collections.abc import Callable
from typing import Final

from rig.hal import Clock

LOOK_EVERY: Final = 10e-3
"""So often it is looked, s, or half as often at worst: a press of an emergency stop is longer."""


class WatchfulClock:
    """The rig's clock, whose sleeps are interrupted for a look; satisfies `rig.hal.Clock`.

    Connecting a rig waits for one device after the other, for up to a second. The loop sleeps by
    the clock itself, as it looks at everything in every cycle.

    Parameters
    ----------
    clock : Clock
        The rig's.
    """

    def __init__(self, clock: Clock) -> None:
        self.now = clock.now
        self._clock = clock
        self._watched: Callable[[], None] | None = None
        self._due = 0.0

    def watch(self, look: Callable[[], None]) -> None:
        """Have `look` called at least every `LOOK_EVERY` while somebody sleeps by this clock."""
        self._watched = look
        self._due = self.now()

    def rest(self) -> None:
        """Look at nothing any more."""
        self._watched = None

    def look(self) -> None:
        """Look now."""
        if self._watched is not None:
            self._due = self.now() + LOOK_EVERY
            self._watched()

    def sleep_until(self, t: float) -> None:
        """Return at `t` (s), and look in between and after it if that is due."""
        sleep_until = self._clock.sleep_until
        while self._watched is not None and self.now() + LOOK_EVERY < t:
            sleep_until(self.now() + LOOK_EVERY)
            self.look()
        sleep_until(t)
        if self.now() >= self._due:
            self.look()
