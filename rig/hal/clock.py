"""The rig's clock: monotonic on hardware, virtual and in lock-step in simulation."""

from time import monotonic, sleep
from typing import Final, Protocol

SPIN: Final = 200e-6
"""For so long before a deadline a loop that spins waits busily, s."""


class Clock(Protocol):
    """Time in seconds that never goes backwards."""

    def now(self) -> float:
        """Return the current time, s."""

    def sleep_until(self, t: float) -> None:
        """Return at time `t` (s) or at once if `t` has passed.

        A simulated clock advances its plants and emulated nodes here, which is why
        every backend runs the same loop.
        """


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

    now = staticmethod(monotonic)
    """Return the current time, s."""

    def sleep_until(self, t: float) -> None:
        """Sleep to `spin` before `t`, then spin to `t`.

        After a sleep the caches are cold and every look-up counts: what is needed then is local.
        """
        spin = self.spin
        wait = t - spin - monotonic()
        if wait > 0.0:
            sleep(wait)
        if spin > 0.0:
            while monotonic() < t:
                pass
