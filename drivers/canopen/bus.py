"""A CAN bus with CANopen devices as the cycle sees it: one place for all its I/O.

No thread: `receive` and `transmit` are called from the loop, and configuration waits by
letting the rig's clock pass (`wait_until`), so that every backend runs the same code and
virtual time is deterministic.
"""

from collections.abc import Callable
from math import inf
from typing import TYPE_CHECKING, Any, Final

from drivers.can.fast_path import Drain, Send, drain_of, send_of
from drivers.can.frame import ERROR_FLAG, EXTENDED_MASK, REMOTE_FLAG
from drivers.canopen.bus_errors import BusErrors
from drivers.canopen.heartbeat import HeartbeatProducer, NmtState
from drivers.canopen.settings import CanBusSettings
from rig.hal import CanBus, Clock

if TYPE_CHECKING:
    from drivers.canopen.network import ThreadlessNetwork

Handler = Callable[[bytes, float], None]

SYNC_ID: Final = 0x080
_NMT_ID: Final = 0x000
_NMT_STOP_ALL: Final = bytes((0x02, 0x00))
_OPERATIONAL: Final = bytes((NmtState.OPERATIONAL,))
_PUMP_PERIOD: Final = 0.5e-3  # how often configuration looks for an answer, s


class TransmitPdo:
    """A PDO that the master sends every cycle, whether its content changed or not.

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
        Sent at all: from the arming of its node until its bus is closed.
    """

    __slots__ = ("active", "can_id", "data", "safe")

    def __init__(self, can_id: int, safe: bytes) -> None:
        self.can_id = can_id
        self.safe = safe
        self.data = safe
        self.active = False


class CanopenBus:
    """The CANopen master of one CAN interface; satisfies `rig.hal.CyclicBus`.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    settings : CanBusSettings
        See there.
    open_bus : callable
        Opens the interface: ``lambda: drivers.can.open_bus(settings)``, or what a test wants.
    clock : Clock
        The rig's.
    period : float, optional
        Of the cycle, and so of SYNC, s; devices that must know it refuse a bus without.

    Attributes
    ----------
    sync_count : int
        SYNCs so far.
    sync_time : float
        When the last one was sent, s.
    """

    def __init__(
        self,
        name: str,
        settings: CanBusSettings,
        open_bus: Callable[[], CanBus],
        clock: Clock,
        period: float | None = None,
    ) -> None:
        self.name = name
        self.settings = settings
        self.clock = clock
        self.period = period
        self.sync_count = 0
        self.sync_time = -inf
        self._now = clock.now
        self._sends_sync = settings.sync
        self._receive_limit = settings.receive_limit
        self._open_bus = open_bus
        self._bus: CanBus | None = None
        self._handlers: dict[int, Handler] = {}
        self._pdos: list[TransmitPdo] = []
        self._heartbeat = HeartbeatProducer(settings.heartbeat)
        self._heartbeat_id = 0x700 + settings.master_id
        self._errors = BusErrors(name, settings.max_refused)
        self._drain: Drain = lambda limit: []
        self._send: Send = _refuse_closed
        self._network: ThreadlessNetwork | None = None
        self._frames_in = 0
        self._frames_out = 0
        self._unknown = 0
        self._remote = 0
        if not settings.sync:
            self.subscribe(SYNC_ID, self._on_foreign_sync)

    # Registration ---------------------------------------------------------------------

    def subscribe(self, can_id: int, handler: Handler) -> None:
        """Have ``handler(data, now)`` called for each data frame with an 11-bit identifier.

        Raises
        ------
        ValueError
            The identifier has a handler already: two devices have the same node number.
        """
        if can_id in self._handlers:
            raise ValueError(
                f"bus {self.name}: identifier 0x{can_id:03X} is used twice; two devices have "
                f"node number 0x{can_id & 0x7F:02X}"
            )
        self._handlers[can_id] = handler

    def add_pdo(self, pdo: TransmitPdo) -> None:
        """Send a PDO each cycle while it is active."""
        self._pdos.append(pdo)

    @property
    def network(self) -> "ThreadlessNetwork":
        """The `canopen` network for configuration; imported on first use."""
        if self._network is None:
            from drivers.canopen.network import ThreadlessNetwork

            self._network = ThreadlessNetwork(self)
        return self._network

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
        self._heartbeat.restart()

    def close(self) -> None:
        """Stop all nodes, by NMT, and release the interface. Idempotent.

        From here on nodes ignore PDOs and SDOs: setpoints must be safe already, and what
        the nodes do when stopped was written to them before they were armed.
        """
        bus, self._bus = self._bus, None
        if bus is None:
            return
        try:
            self._send(_NMT_ID, _NMT_STOP_ALL)
        except Exception as error:  # the interface may be the very thing that failed
            self._errors.refuse(error)
        finally:
            self._drain, self._send = (lambda limit: []), _refuse_closed
            for pdo in self._pdos:
                pdo.active = False
            bus.shutdown()

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

    def transmit(self, now: float) -> None:
        """Send this cycle's setpoints, SYNC, and the heartbeat if it is due. Hot path.

        What the interface refuses is not tried again: the cycle counts as missed.
        """
        if self._exchange() and now >= self._heartbeat.due:
            try:
                self._send(self._heartbeat_id, _OPERATIONAL)
            except Exception as error:
                self._errors.refuse(error)
            else:
                self._frames_out += 1
                self._heartbeat.sent(now)

    def synchronise(self) -> None:
        """Send setpoints and SYNC, but no heartbeat: for first readings while arming.

        Nodes watch the master from its first heartbeat on, which the running loop sends.
        """
        self._exchange()

    def check(self, now: float) -> None:
        """Raise if the bus is not well.

        Raises
        ------
        DeviceFault
            Interface down, bus-off, error passive, restarted, or frames refused.
        """
        self._errors.check()

    def make_safe(self) -> None:
        """Send the safe setpoints of every driver now. Never raises."""
        for pdo in self._pdos:
            pdo.data = pdo.safe
        self._exchange()

    def statistics(self) -> dict[str, float]:
        """Return counters for the run's manifest."""
        return {
            "frames_in": self._frames_in,
            "frames_out": self._frames_out,
            "unknown": self._unknown,
            "remote": self._remote,
            "error_frames": self._errors.error_frames,
            "refused": self._errors.refused,
            "syncs": self.sync_count,
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

    # Inside ---------------------------------------------------------------------------

    def _exchange(self) -> bool:
        send = self._send
        sent = 0
        try:
            for pdo in self._pdos:
                if pdo.active:
                    send(pdo.can_id, pdo.data)
                    sent += 1
            if self._sends_sync:
                send(SYNC_ID, b"")
                sent += 1
                self.sync_count += 1
                self.sync_time = self._now()
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

    def _on_foreign_sync(self, data: bytes, now: float) -> None:
        self.sync_count += 1
        self.sync_time = now


def _refuse_closed(can_id: int, data: bytes) -> None:
    raise OSError("the bus is not open")
