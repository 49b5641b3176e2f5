"""A rig that is energised for one step: its cycle without a law, a loop or a motion."""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from rig.assembly import Rig


class StepBench:
    """The cycle of an energised rig, as far as a step needs it.

    Parameters
    ----------
    rig : Rig
        Connected and armed.

    Attributes
    ----------
    each_cycle : callable
        Gives this cycle's setpoints, once its readings are there; does nothing by default. A loop
        that is closed in this program must not pause: a valve keeps its last opening.
    """

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self._period = rig.profile.loop.period
        self._is_safe = False
        self.each_cycle: Callable[[], None] = _nothing
        # A camera moves nothing, and is read by a mechanism alone.
        entries = rig.profile.devices
        self._on_buses = [rig.devices[name] for name in entries if entries[name].bus is not None]

    @property
    def now(self) -> float:
        """The rig's time, s."""
        return self.rig.clock.now()

    def cycle(self) -> None:
        """Receive, check every device, send this cycle's setpoints, and sleep.

        Once the rig was made safe nobody checks: a joint that is let go may fall, faster than a
        joint may be.

        Raises
        ------
        DeviceFault
            A device or a bus is not well.
        """
        rig, now = self.rig, self.now
        for bus in rig.buses.values():
            bus.receive(now)
        if not self._is_safe:
            for device in self._on_buses:
                device.check(now)
            for bus in rig.buses.values():
                bus.check(now)
        self.each_cycle()
        for bus in rig.buses.values():
            bus.transmit(now)
        rig.clock.sleep_until(now + self._period)

    def run(self, duration: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Cycle for so long (s), or until something is so; return whether it is."""
        end = self.now + duration
        while not until():
            if self.now >= end:
                return False
            self.cycle()
        return True

    def make_safe(self) -> None:
        """Take the safe setpoints from the next cycle on."""
        self._is_safe = True
        self.each_cycle = _nothing
        for device in self.rig.devices.values():
            device.make_safe()

    def listen(self, duration: float, until: Callable[[], bool]) -> bool:
        """Only listen, for so long (s) or until something is so; return whether it is."""
        end = self.now + duration
        while not until():
            if self.now >= end:
                return False
            for bus in self.rig.buses.values():
                bus.receive(self.now)
            self.rig.clock.sleep_until(self.now + self._period)
        return True

    def die(self, after: float) -> None:
        """Have the master live on for `after` (s), and then die without a word.

        On a real bus another process is the master meanwhile, and is killed; this one listens. In
        virtual time, which one process has alone, it falls silent in mid-cycle instead.
        """
        if self.rig.backend.is_simulated:
            self.run(after)
            return
        with _master(partial(self._transmit_on, os.getpid())):
            self.listen(after, lambda: False)

    def _transmit_on(self, parent: int) -> None:
        clock = self.rig.clock
        while os.getppid() == parent:  # who kills this one may have been killed before
            now = clock.now()
            for bus in self.rig.buses.values():
                bus.transmit(now)
            clock.sleep_until(now + self._period)


def _nothing() -> None:
    """Leave the setpoints as they are."""


@contextmanager
def _master(work: Callable[[], None]) -> Iterator[None]:
    """Have another process do the work until the block is left, and kill it then."""
    child = os.fork()
    if child == 0:
        try:
            work()
        finally:
            os._exit(1)
    try:
        yield
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
