"""Virtual time: sleeping is what lets the simulated world move."""

from typing import Protocol


class World(Protocol):
    """Whatever moves while the program sleeps: a plant, or a whole emulated rig."""

    def advance(self, t: float) -> None:
        """Let time pass up to `t`, s."""


class SimClock:
    """A clock in lock-step with a simulated world.

    Time stands still while the program computes, so a run depends neither on the machine's
    speed nor on its load.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self._now = 0.0
        self._pause = 0.0

    def pause(self, duration: float) -> None:
        """Have the sleep that goes on now take `duration` (s) longer, as when a host stalls."""
        self._pause += duration

    def now(self) -> float:
        """Return the virtual time, s; 0 at the start."""
        return self._now

    def sleep_until(self, t: float) -> None:
        """Advance the world to `t` (s); a time that has passed changes nothing.

        Raises
        ------
        ValueError
            `t` is not a finite number: the world would never get there.
        """
        if t <= self._now:
            return
        if not t < float("inf"):
            raise ValueError(f"The simulated clock cannot sleep until {t}.")
        self.world.advance(t)
        self._now = t
        if self._pause > 0.0:
            pause, self._pause = self._pause, 0.0
            self.sleep_until(t + pause)
