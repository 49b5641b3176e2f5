"""The emulated rig in the time of the wall clock, for programs in other processes.

Two processes share a real interface: one runs the production drivers as it would on the rig,
the other holds the devices and the physics, and answers within the bus's time.
"""

import errno
import os
import select
import tty
from collections.abc import Callable, Sequence
from time import monotonic, sleep
from typing import Final, Protocol

from drivers.can import close_bus
from drivers.can.errors import error_number
from drivers.sim.dynamixel.line import MemoryPort
from drivers.sim.emulated_rig import EmulatedRig
from rig.hal import DeviceFault, FastCanBus

IDLE: Final = 2e-3
"""Longest time between two looks at the world while nobody sends, s."""
LONGEST_STEP: Final = 20e-3
"""Most time that passes for the world at once, s; well under any heartbeat's time-out."""
_POLL: Final = 0.5e-3  # of an interface that cannot be waited for, s


class End(Protocol):
    """The simulated end of an interface."""

    def fileno(self) -> int:
        """Return what to wait for, or -1 if it can only be looked at."""

    def take(self, origin: float) -> None:
        """Take what has come.

        Parameters
        ----------
        origin : float
            What the wall clock shows when the world's time is 0, s.
        """

    def give(self) -> None:
        """Hand over what the devices have answered."""

    def close(self) -> None:
        """Release the interface. Idempotent."""


class CanEnd(FastCanBus):
    """The simulated end of a CAN interface, which outlives outages.

    Devices do not end because their bus is down: what cannot be sent is lost and counted.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    bus : FastCanBus
        The interface, open. It is owned from now on.

    Attributes
    ----------
    received, sent, lost : int
        Frames from and to the master, and those that the interface refused.
    trouble : str or None
        What the interface said when it last refused one, until it takes one again.
    """

    def __init__(self, name: str, bus: FastCanBus) -> None:
        self.name = name
        self.received = self.sent = self.lost = 0
        self.trouble: str | None = None
        self._bus = bus
        self._fd = bus.fileno()

    def fileno(self) -> int:
        """Return what to wait for, or -1."""
        return self._fd

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the waiting frames, at most `limit`.

        Raises
        ------
        DeviceFault
            The interface is gone for good.
        """
        try:
            frames = self._bus.drain(limit)
        except Exception as error:  # each interface has errors of its own
            self._note(error)
            return []
        self.received += len(frames)
        return frames

    def send_data(self, can_id: int, data: bytes) -> None:
        """Send a frame if the interface takes it.

        Raises
        ------
        DeviceFault
            The interface is gone for good.
        """
        try:
            self._bus.send_data(can_id, data)
        except Exception as error:
            self.lost += 1
            self._note(error)
        else:
            self.sent += 1
            self.trouble = None

    def take(self, origin: float) -> None:
        """Do nothing: the emulated bus itself takes frames, by `drain`."""

    def give(self) -> None:
        """Do nothing: frames are sent when the devices send them."""

    def close(self) -> None:
        """Release the interface."""
        close_bus(self._bus)

    shutdown = close

    def _note(self, error: Exception) -> None:
        if error_number(error) in (errno.ENODEV, errno.ENXIO):
            raise DeviceFault(self.name, f"the interface is gone: {error}") from error
        self.trouble = str(error)


class TerminalEnd:
    """The simulated end of a serial line: a pseudo-terminal that another program opens.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    port : MemoryPort
        The host's end of the emulated line.

    Attributes
    ----------
    path : str
        What the other program opens.
    received, sent, lost : int
        Bytes from and to the master, and those that nobody took.
    """

    def __init__(self, name: str, port: MemoryPort) -> None:
        self.name = name
        self.received = self.sent = self.lost = 0
        self.trouble: str | None = None
        self._port = port
        self._master, self._slave = os.openpty()
        # Kept open, so that the terminal lives on when its user closes it.
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.path = os.ttyname(self._slave)

    def fileno(self) -> int:
        """Return what to wait for."""
        return self._master

    def take(self, origin: float) -> None:
        """Put what has come on the emulated line."""
        try:
            data = os.read(self._master, 4096)
        except OSError:  # nothing there
            return
        self.received += len(data)
        # Added to what waits: the line takes all of it at the world's next step.
        self._port.written += data

    def give(self) -> None:
        """Hand over what the devices have answered."""
        data = self._port.read(4096)
        if not data:
            return
        try:
            taken = os.write(self._master, data)
        except BlockingIOError:  # nobody reads
            taken = 0
        self.sent += taken
        self.lost += len(data) - taken

    def close(self) -> None:
        """Release the terminal."""
        for end in (self._master, self._slave):
            if end >= 0:
                os.close(end)
        self._master = self._slave = -1


class WallClockRig:
    """An emulated rig that lives in real time.

    If this process is held up for longer than `LONGEST_STEP`, the world stands still for the
    rest, or its nodes would miss heartbeats that wait in the socket and vent for no reason
    that a real device has.

    Parameters
    ----------
    world : EmulatedRig
        With `bus_latency` 0: the interface has its own.
    ends : sequence of End
        Of all its buses.
    clock, pause : callable
        The time (s), and what lets it pass while nothing can be waited for.

    Attributes
    ----------
    held_up : float
        How long the world has stood still in all, s.
    """

    def __init__(
        self,
        world: EmulatedRig,
        ends: Sequence[End],
        clock: Callable[[], float] = monotonic,
        pause: Callable[[float], None] = sleep,
    ) -> None:
        self.world = world
        self.held_up = 0.0
        self._ends = tuple(ends)
        self._clock = clock
        self._pause = pause
        self._waits = [end.fileno() for end in self._ends]
        # Kernels are compiled, and their caches filled, before anybody sends.
        world.advance(world.time + LONGEST_STEP)
        self._origin = clock() - world.time

    def serve(self, is_over: Callable[[], bool]) -> None:
        """Live until it is over.

        Raises
        ------
        DeviceFault
            An interface is gone for good.
        """
        while not is_over():
            self.serve_once()

    def serve_once(self, longest: float = IDLE) -> None:
        """Wait for a frame, for what a node does of itself or for `longest` (s), and answer."""
        self._wait(min(self.world.due + self._origin - self._clock(), longest))
        now = self._clock() - self._origin
        excess = now - self.world.time - LONGEST_STEP
        if excess > 0.0:
            self.held_up += excess
            self._origin += excess
            now -= excess
        for end in self._ends:
            end.take(self._origin)
        # A frame meets the plant as it is now, not as it was when the last one came.
        self.world.pass_until(now)
        self.world.advance(now)
        for end in self._ends:
            end.give()

    def _wait(self, wait: float) -> None:
        if wait <= 0.0:
            return
        if min(self._waits) < 0:
            self._pause(min(wait, _POLL))
        else:
            select.select(self._waits, (), (), wait)
