"""A CAN bus as the cycle sees it: what is the same whatever is spoken on it.

No thread: `receive` and `transmit` are called from the loop, and configuration waits by letting
the rig's clock pass (`wait_until`), so that every backend runs the same code and virtual time is
deterministic.
"""

import errno
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Final

from drivers.can.bus_settings import CanInterfaceSettings
from drivers.can.errors import BusErrors
from drivers.can.fast_path import Drain, Send
from drivers.can.frame import ERROR_FLAG, EXTENDED_MASK, REMOTE_FLAG
from drivers.can.interfaces import close_bus
from rig.hal import Clock, ConnectionFailed, FastCanBus

Handler = Callable[[bytes, float], None]

_PUMP_PERIOD: Final = 0.5e-3  # how often configuration looks for an answer, s
_STILL_WAITING: Final = OSError(errno.ENOBUFS, "the frames of the last cycle still wait")


class CyclicFrame:
    """A frame that the master sends every cycle while it is active, changed or not.

    A lost one does not matter: the next cycle has a newer one.

    Parameters
    ----------
    can_id : int
        Its identifier.
    safe : bytes
        Its content in the safe state, and until a driver sets another.

    Attributes
    ----------
    data : bytes
        What the next cycle sends.
    active : bool
        Sent at all; a driver says when, and closing the bus ends it.
    """

    __slots__ = ("active", "can_id", "data", "safe")

    def __init__(self, can_id: int, safe: bytes) -> None:
        self.can_id = can_id
        self.safe = safe
        self.data = safe
        self.active = False


class CyclicCanBus(ABC):
    """The master's end of one CAN interface; what it sends each cycle is the protocol's.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    settings : CanInterfaceSettings
        See there.
    open_bus : callable
        Opens the interface: ``lambda: drivers.can.open_bus(settings)``, or what a test wants.
    clock : Clock
        The rig's.
    period : float, optional
        Of the cycle, s; devices that must know it refuse a bus without.
    """

    _farewell: tuple[int, bytes] | None = None
    """The protocol's last frame on a bus, sent when it is closed."""

    def __init__(
        self,
        name: str,
        settings: CanInterfaceSettings,
        open_bus: Callable[[], FastCanBus],
        clock: Clock,
        period: float | None = None,
    ) -> None:
        self.name = name
        self.clock = clock
        self.period = period
        self._receive_limit = settings.receive_limit
        self._max_refused = settings.max_refused
        self._open_bus = open_bus
        self._bus: FastCanBus | None = None
        self._handlers: dict[int, Handler] = {}
        self._cyclic: list[CyclicFrame] = []
        self._errors = BusErrors(name, settings.max_refused)
        self._drain: Drain = _nothing
        self._send: Send = _refuse_closed
        self._backlog: Callable[[], int] = int
        self._frames_in = 0
        self._frames_out = self._out_before = 0
        self._unknown = 0
        self._unheard: int  # since it was opened
        self._remote = 0
        self._dropped = 0
        self._another: str | None = None

    # Registration ---------------------------------------------------------------------

    def subscribe(self, can_id: int, handler: Handler) -> None:
        """Have ``handler(data, now)`` called for each data frame with an 11-bit identifier.

        Raises
        ------
        ValueError
            The identifier has a handler already: two devices have one number.
        """
        if can_id in self._handlers:
            raise ValueError(
                f"bus {self.name}: identifier 0x{can_id:03X} is used twice; two "
                f"{self._owners(can_id)}"
            )
        self._handlers[can_id] = handler

    def add(self, frame: CyclicFrame) -> None:
        """Send a frame each cycle while it is active."""
        self._cyclic.append(frame)
        self.claim(frame.can_id, "setpoints")

    def claim(self, can_id: int, what: str) -> None:
        """Take an identifier that nobody but this program sends; from outside it is a fault."""
        self.subscribe(can_id, lambda data, now: self._hear_another(can_id, what))

    @abstractmethod
    def _owners(self, can_id: int) -> str:
        """Say who would have the same identifier: ``"devices have node number 0x01"``."""

    # Life cycle -----------------------------------------------------------------------

    def open(self) -> None:
        """Open the interface. Idempotent.

        Raises
        ------
        ConnectionFailed
            It is missing, down or unknown.
        """
        if self._bus is not None:
            return
        self._bus = bus = self._open_bus()
        self._drain, self._send, self._backlog = bus.drain, bus.send_data, bus.backlog
        self._out_before = self._frames_out
        self._unheard = 0
        bus.accept(self._handlers)
        self._errors = BusErrors(self.name, self._max_refused)
        self._another = None

    def open_interface(self) -> FastCanBus:
        """Open the interface for somebody else than this bus, which is not open; he shuts it down.

        Raises
        ------
        ConnectionFailed
            It is missing, down or unknown.
        """
        return self._open_bus()

    def expect_alone(self, duration: float) -> None:
        """Only listen, before the first frame is sent, and raise if the bus has a master.

        Raises
        ------
        ConnectionFailed
            Somebody sends what only this program is to send.
        """
        if self.wait_until(lambda: self._another is not None, duration):
            raise ConnectionFailed(
                self.name,
                f"another master is on the bus: {self._another}; end it, or wait for its end",
            )

    @property
    def has_spoken(self) -> bool:
        """Whether anything was sent since the interface was opened.

        Until then the bus may be another master's, whose nodes are not to be stopped.
        """
        return self._frames_out > self._out_before

    def _hear_another(self, can_id: int, what: str) -> None:
        self._another = f"somebody sends {what} (identifier 0x{can_id:03X})"
        if self.has_spoken:
            self._errors.share(self._another)

    def close(self) -> None:
        """Release the interface. Idempotent."""
        self._count_held_back()
        bus, self._bus = self._bus, None
        if bus is None:
            return
        self._dropped += bus.count_dropped()
        try:
            if self._farewell is not None and self.has_spoken:
                self._send(*self._farewell)
        except Exception as error:  # the interface may be the very thing that failed
            self._errors.refuse(error)
        finally:
            self._drain, self._send, self._backlog = _nothing, _refuse_closed, int
            for frame in self._cyclic:
                frame.active = False
            close_bus(bus)

    # The cycle ------------------------------------------------------------------------

    def receive(self, now: float) -> None:
        """Take every waiting frame to its handler. Hot path."""
        try:
            frames = self._drain(self._receive_limit)
        except Exception as error:  # OSError or the interface's own
            self._errors.lose(error)
            return
        self._frames_in += len(frames)
        handlers = self._handlers
        for can_id, data in frames:
            # Flags are part of the identifier here, so that only plain data frames match.
            handler = handlers.get(can_id)
            if handler is not None:
                handler(data, now)
            else:
                self._receive_other(can_id, data)

    def check(self, now: float) -> None:
        """Raise if the bus is not well.

        Raises
        ------
        DeviceFault
            Interface down, bus-off, error passive, restarted, or frames refused.
        """
        self._errors.check()

    def statistics(self) -> dict[str, float]:
        """Return counters for the run's manifest."""
        self._count_held_back()
        return {
            "frames_in": self._frames_in,
            "frames_out": self._frames_out,
            "unknown": self._unknown,
            "remote": self._remote,
            "error_frames": self._errors.error_frames,
            "refused": self._errors.refused,
            "lost": self._errors.lost,
            "dropped": self._dropped,
        }

    def _count_held_back(self) -> None:
        """Count the unknown frames that a kernel's filters held back since this was last asked.

        Among them are the master's own, but those that it claims and so would hear.
        """
        if self._bus is not None:
            others = self._bus.count_others() - self._unheard
            self._unknown += max(0, others)
            self._unheard = max(0, -others)  # some may be on their way still

    def _send_cyclic(self, *more: tuple[int, bytes]) -> bool:
        """Send the active frames, then some more; return whether all were taken. Hot path.

        What the interface refuses is not tried again, and what would follow it is not sent: the
        cycle counts as missed. So it does while the frames of the last one still wait: setpoints
        must not pile up behind an outage and come out after it.
        """
        send = self._send
        sent = 0
        try:
            if self._backlog() and not self._errors.latched:
                raise _STILL_WAITING
            for frame in self._cyclic:
                if frame.active:
                    send(frame.can_id, frame.data)
                    sent += 1
            for can_id, data in more:
                send(can_id, data)
                sent += 1
        except Exception as error:
            self._frames_out += sent
            self._errors.refuse(error)
            return False
        self._frames_out += sent
        self._errors.sent()
        return True

    def _receive_other(self, can_id: int, data: bytes) -> None:
        if can_id & ERROR_FLAG:
            self._errors.receive(can_id & EXTENDED_MASK & ~ERROR_FLAG, data)
        elif can_id & REMOTE_FLAG:
            self._remote += 1
        else:
            self._unknown += 1

    # Configuration --------------------------------------------------------------------

    def send(self, can_id: int, data: bytes) -> None:
        """Send one frame now, outside the cycle.

        Raises
        ------
        OSError, can.CanError
            The interface refuses it.
        """
        self._send(can_id, data)
        self._frames_out += 1
        self._unheard += can_id not in self._handlers

    def wait_until(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Receive until a condition holds; return whether it does.

        Parameters
        ----------
        condition : callable
            Looked at after each batch of frames.
        timeout : float
            On the rig's clock, s.

        Raises
        ------
        DeviceFault
            The bus itself failed meanwhile.
        """
        clock = self.clock
        now = clock.now()
        deadline = now + timeout
        while True:
            self.receive(now)
            if condition():
                return True
            self._errors.check()
            if now >= deadline:
                return False
            clock.sleep_until(now + _PUMP_PERIOD)
            now = clock.now()


def _nothing(limit: int) -> list[tuple[int, bytes]]:
    return []


def _refuse_closed(can_id: int, data: bytes) -> None:
    raise OSError("the bus is not open")
