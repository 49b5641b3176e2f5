"""A CAN bus with CANSimple axes as the cycle sees it: one place for all its I/O.

There is no network management here: axes send by their own clocks, and the setpoints that
feed their watchdogs are the only sign of life of the master. No thread, as on a CANopen bus:
`receive` and `transmit` are called from the loop, and configuration waits by letting the rig's
clock pass (`wait_until`).
"""

from collections.abc import Callable
from math import inf
from typing import Any, Final

from drivers.can.fast_path import Drain, Send, drain_of, send_of
from drivers.can.frame import ERROR_FLAG, EXTENDED_MASK, REMOTE_FLAG
from drivers.canopen.bus_errors import BusErrors
from drivers.servos.odrive_settings import OdriveBusSettings
from rig.hal import CanBus, Clock

Handler = Callable[[bytes, float], None]

_PUMP_PERIOD: Final = 0.5e-3  # how often configuration looks for an answer, s


class Setpoint:
    """A frame that the master sends every cycle while it is active.

    Parameters
    ----------
    can_id : int
        Its identifier.
    data : bytes
        What the next cycle sends.

    Attributes
    ----------
    active : bool
        Sent at all: from the arming of its axis until it is idle again.
    """

    __slots__ = ("active", "can_id", "data")

    def __init__(self, can_id: int, data: bytes) -> None:
        self.can_id = can_id
        self.data = data
        self.active = False


class OdriveBus:
    """The master of CANSimple axes on one CAN interface; satisfies `rig.hal.CyclicBus`.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    settings : OdriveBusSettings
        See there.
    open_bus : callable
        Opens the interface: ``lambda: drivers.can.open_bus(settings)``, or what a test wants.
    clock : Clock
        The rig's.
    period : float, optional
        Of the cycle, s; devices that must know it refuse a bus without.

    Attributes
    ----------
    received_before : float
        When frames were received before the last time, s: what came then was sent after it.
    """

    def __init__(
        self,
        name: str,
        settings: OdriveBusSettings,
        open_bus: Callable[[], CanBus],
        clock: Clock,
        period: float | None = None,
    ) -> None:
        self.name = name
        self.settings = settings
        self.clock = clock
        self.period = period
        self.received_before = -inf
        self._received = -inf
        self._open_bus = open_bus
        self._bus: CanBus | None = None
        self._handlers: dict[int, Handler] = {}
        self._setpoints: list[Setpoint] = []
        self._errors = BusErrors(name, settings.max_refused)
        self._drain: Drain = _nothing
        self._send: Send = _refuse_closed
        self._frames_in = 0
        self._frames_out = 0
        self._unknown = 0
        self._remote = 0

    # Registration ---------------------------------------------------------------------

    def subscribe(self, can_id: int, handler: Handler) -> None:
        """Have ``handler(data, now)`` called for each data frame with an 11-bit identifier.

        Raises
        ------
        ValueError
            The identifier has a handler already: two joints have the same axis.
        """
        if can_id in self._handlers:
            raise ValueError(
                f"bus {self.name}: identifier 0x{can_id:03X} is used twice; two joints have "
                f"axis {can_id >> 5}"
            )
        self._handlers[can_id] = handler

    def add_setpoint(self, setpoint: Setpoint) -> None:
        """Send a frame each cycle while it is active."""
        self._setpoints.append(setpoint)

    # Life cycle -----------------------------------------------------------------------

    def open(self) -> None:
        """Open the interface.

        Raises
        ------
        ConnectionFailed
            It is missing, down or unknown.
        """
        if self._bus is not None:
            return
        bus: Any = self._open_bus()
        self._bus = bus
        self._drain, self._send = drain_of(bus), send_of(bus)
        accept = getattr(bus, "accept", None)
        if accept is not None:
            accept(self._handlers)
        self._errors = BusErrors(self.name, self.settings.max_refused)

    def close(self) -> None:
        """Release the interface. Idempotent.

        What still moves loses its setpoints, and its watchdog takes the torque away.
        """
        bus, self._bus = self._bus, None
        if bus is None:
            return
        self._drain, self._send = _nothing, _refuse_closed
        for setpoint in self._setpoints:
            setpoint.active = False
        bus.shutdown()

    # The cycle ------------------------------------------------------------------------

    def receive(self, now: float) -> None:
        """Take every waiting frame to its handler. Hot path."""
        self.received_before, self._received = self._received, now
        try:
            frames = self._drain(self.settings.receive_limit)
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
            elif can_id & ERROR_FLAG:
                self._errors.receive(can_id & EXTENDED_MASK & ~ERROR_FLAG, data)
            elif can_id & REMOTE_FLAG:
                self._remote += 1
            else:
                self._unknown += 1

    def transmit(self, now: float) -> None:
        """Send this cycle's setpoints, which feed the watchdogs. Hot path.

        What the interface refuses is not tried again: the cycle counts as missed.
        """
        send = self._send
        sent = 0
        try:
            for setpoint in self._setpoints:
                if setpoint.active:
                    send(setpoint.can_id, setpoint.data)
                    sent += 1
        except Exception as error:
            self._errors.refuse(error)
        else:
            self._errors.sent()
        self._frames_out += sent

    def check(self, now: float) -> None:
        """Raise if the bus is not well.

        Raises
        ------
        DeviceFault
            Interface down, bus-off, error passive, restarted, or frames refused.
        """
        self._errors.check()

    def make_safe(self) -> None:
        """Send the setpoints that the drivers left, which are their safe ones. Never raises."""
        self.transmit(self.clock.now())

    def statistics(self) -> dict[str, float]:
        """Return counters for the run's manifest."""
        return {
            "frames_in": self._frames_in,
            "frames_out": self._frames_out,
            "unknown": self._unknown,
            "remote": self._remote,
            "error_frames": self._errors.error_frames,
            "refused": self._errors.refused,
        }

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

    def request(self, can_id: int) -> None:
        """Ask for a frame with a remote frame; errors as `send`."""
        self.send(can_id | REMOTE_FLAG, b"")

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
