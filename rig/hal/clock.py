"""The rig's clock: monotonic on hardware, virtual and in lock-step in simulation."""

import time
from typing import Protocol


class Clock(Protocol):
    """Time in seconds that never goes backwards."""

    def now(self) -> float:
        """Return the current time, s."""
        ...

    def sleep_until(self, t: float) -> None:
        """Return at time `t` (s) or at once if `t` has passed.

        A simulated clock advances its plants and emulated nodes here, which is why
        every backend runs the same loop.
        """
        ...


class MonotonicClock:
    """The kernel's monotonic clock, with an optional spin before each deadline.

    Parameters
    ----------
    spin : float
        Busy-wait the last `spin` seconds before a deadline. Only worth its processor
        time under SCHED_FIFO: elsewhere the scheduler takes the core away anyway.
    """

    def __init__(self, spin: float = 0.0) -> None:
        self.spin = spin

    def now(self) -> float:
        """Return the current time, s."""
        return time.monotonic()

    def sleep_until(self, t: float) -> None:
        """Sleep to `spin` before `t`, then spin to `t`."""
        wait = t - self.spin - time.monotonic()
        if wait > 0.0:
            time.sleep(wait)
        if self.spin > 0.0:
            while time.monotonic() < t:
                pass
