"""A serial bus with Dynamixel servos as the cycle sees it: one place for all its I/O.

Half duplex: in each cycle the setpoints go out in one sync write, which nobody answers, then
one (fast) sync read, whose answer comes while the loop sleeps and is taken at the start of
the next cycle. So the loop never waits for a servo, and the wire is never driven from both
ends. No thread; configuration waits by letting the rig's clock pass.
"""

from collections.abc import Callable, Sequence
from math import inf
from typing import Final

from drivers.dynamixel.codec import BROADCAST_ID, Status, decode_status, encode_sync_write
from drivers.dynamixel.links import CyclicRead
from drivers.dynamixel.parser import StatusParser
from drivers.dynamixel.port import SerialPort
from drivers.dynamixel.settings import SerialBusSettings
from rig.hal import Clock, DeviceFault

_PUMP_PERIOD: Final = 0.25e-3  # how often configuration looks for an answer, s
_ANSWERED: Final = 0.7  # share of the period that an answer may take: the line's load is less
_READ_LIMIT: Final = 8192  # bytes of one cycle; a port that floods cannot stop the loop


class SyncWrite:
    """Registers of several servos that are written every cycle, changed or not.

    A lost one does not matter: the next cycle has a newer one.

    Parameters
    ----------
    address, size : int
        Of the registers, bytes.
    payload : bytes
        Per servo its id and `size` bytes.

    Attributes
    ----------
    active : bool
        Sent at all.
    """

    __slots__ = ("active", "address", "payload", "size")

    def __init__(self, address: int, size: int, payload: bytes) -> None:
        self.address = address
        self.size = size
        self.payload = payload
        self.active = False


class SerialBus:
    """The host on one chain of servos; satisfies `rig.hal.CyclicBus`.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    settings : SerialBusSettings
        See there.
    open_port : callable
        Opens the port: ``lambda: drivers.dynamixel.port.open_port(settings)``, or what a
        simulation wants.
    clock : Clock
        The rig's.
    period : float, optional
        Of the cycle, s: an answer that takes longer comes too late. Devices that must know
        it refuse a bus without.

    Attributes
    ----------
    read : CyclicRead
        The cyclic reading; devices join it.
    max_latency : float
        The slowest answer that is accepted while connecting, s.
    request_time : float
        When the last reading was asked for, which is when the servos sampled, s.
    lost_setpoints : list of callable
        Each returns how many setpoints of a servo left no trace.
    """

    def __init__(
        self,
        name: str,
        settings: SerialBusSettings,
        open_port: Callable[[], SerialPort],
        clock: Clock,
        period: float | None = None,
    ) -> None:
        self.name = name
        self.settings = settings
        self.clock = clock
        self.period = period
        self.max_latency = min(settings.max_latency, period or settings.max_latency)
        self.read = CyclicRead(fast=settings.fast_sync, fault_after=settings.fault_after)
        self.request_time = -inf
        self.lost_setpoints: list[Callable[[], int]] = []
        self._open_port = open_port
        self._port: SerialPort | None = None
        self._parser = StatusParser()
        self._writes: list[SyncWrite] = []
        self._listeners: list[Callable[[float], None]] = []
        self._ahead: tuple[list[bytes], list[bytes]] = ([], [])
        self._asked = False
        self._trouble: DeviceFault | None = None
        self._refused_in_a_row = 0
        self._refused = 0
        self._bytes_in = 0
        self._bytes_out = 0

    # Registration ---------------------------------------------------------------------

    def add_write(self, write: SyncWrite) -> None:
        """Send a sync write in each cycle in which it is active."""
        self._writes.append(write)

    def listen(self, take: Callable[[float], None]) -> None:
        """Have ``take(t)`` called when the answers to a reading asked for at `t` are in."""
        self._listeners.append(take)

    def send_ahead(self, packet: bytes) -> None:
        """Send a packet that nobody answers ahead of the next two cycles' setpoints.

        Twice, because it may get lost and nobody would know.
        """
        for packets in self._ahead:
            packets.append(packet)

    # Life cycle -----------------------------------------------------------------------

    def open(self) -> None:
        """Open the port.

        Raises
        ------
        ConnectionFailed
            It is missing, in use or not permitted.
        """
        if self._port is not None:
            return
        self._port = self._open_port()
        self._trouble = None
        self._refused_in_a_row = 0
        self._asked = False
        self._ahead = ([], [])
        self._parser.finish()

    def expect_alone(self, duration: float) -> None:
        """Do nothing: a serial port has one user, and opening it has shown that."""

    def close(self) -> None:
        """Release the port. Idempotent.

        Nothing is sent any more, so an armed bus watchdog stops the servos that hold.
        """
        port, self._port = self._port, None
        for write in self._writes:
            write.active = False
        self._asked = False
        if port is not None:
            port.close()

    # The cycle ------------------------------------------------------------------------

    def receive(self, now: float) -> None:
        """Take the answer to the request of the cycle before. Hot path."""
        data = self._take_bytes()
        if not self._asked:
            if data:
                self._parser.feed(data)
                self._parser.finish()
            return
        self._asked = False
        # A cycle that was late asks late, too: what then has not come is not the servos' doing.
        gone = now - self.request_time
        in_time = self.period is None or gone >= _ANSWERED * self.period
        self.read.settle(data, self._parser, in_time=in_time)
        for take in self._listeners:
            take(self.request_time)

    def transmit(self, now: float) -> None:
        """Send what is due once, this cycle's setpoints, and the request. Hot path."""
        packets, later = self._ahead
        self._ahead = (later, [])
        self._exchange(packets)

    def synchronise(self) -> None:
        """Send setpoints and the request only: for first readings while arming."""
        self._exchange([])

    def check(self, now: float) -> None:
        """Raise if the bus is not well.

        Raises
        ------
        DeviceFault
            The adapter is gone, or refuses bytes.
        """
        if self._trouble is not None:
            raise self._trouble

    def make_safe(self) -> None:
        """Send the setpoints that stand, which are the safe ones by now. Never raises."""
        self._exchange([])

    def statistics(self) -> dict[str, float]:
        """Return counters for the run's manifest."""
        found = {
            "bytes_in": self._bytes_in,
            "bytes_out": self._bytes_out,
            "refused": self._refused,
            "corrupt": self._parser.corrupt,
            "noise": self._parser.noise,
            **self.read.statistics(),
        }
        if self.lost_setpoints:
            found["lost_setpoints"] = sum(lost() for lost in self.lost_setpoints)
        return found

    # Configuration --------------------------------------------------------------------

    def ask(
        self, packet: bytes, enough: Callable[[Sequence[Status]], bool], timeout: float
    ) -> tuple[list[Status], bool]:
        """Send one packet and take answers until there are enough, or the time is over.

        Parameters
        ----------
        packet : bytes
            The instruction.
        enough : callable
            Looks at the answers so far.
        timeout : float
            On the rig's clock, s.

        Returns
        -------
        list of Status
            The answers.
        bool
            Whether something damaged came, too.

        Raises
        ------
        DeviceFault
            The port itself failed.
        """
        parser, clock = self._parser, self.clock
        self._take_bytes()
        parser.finish()
        self._asked = False
        corrupt, noise = parser.corrupt, parser.noise
        answers: list[Status] = []
        self._put_bytes(packet)
        self.check(clock.now())
        deadline = clock.now() + timeout
        while not enough(answers) and clock.now() < deadline:
            clock.sleep_until(clock.now() + _PUMP_PERIOD)
            packets = parser.feed(self._take_bytes())
            self.check(clock.now())
            answers += [decode_status(item) for item in packets if item[4] != BROADCAST_ID]
        more, part = parser.finish()
        answers += [decode_status(item) for item in more if item[4] != BROADCAST_ID]
        damaged = parser.corrupt != corrupt or parser.noise != noise or bool(part)
        return answers, damaged

    def wait(self, duration: float) -> None:
        """Let time pass, s."""
        self.clock.sleep_until(self.clock.now() + duration)

    # Inside ---------------------------------------------------------------------------

    def _exchange(self, packets: list[bytes]) -> None:
        for write in self._writes:
            if write.active:
                packets.append(encode_sync_write(write.address, write.size, write.payload))
        request = self.read.request
        if request:
            packets.append(request)
        if not packets:
            return
        self._put_bytes(b"".join(packets))
        if request:
            self._asked = True
            self.request_time = self.clock.now()

    def _take_bytes(self) -> bytes:
        port = self._port
        if port is None or self._trouble is not None:
            return b""
        try:
            data = port.read(_READ_LIMIT)
        except OSError as error:
            self._lose(error)
            return b""
        self._bytes_in += len(data)
        return data

    def _put_bytes(self, data: bytes) -> None:
        port = self._port
        if port is None or self._trouble is not None:
            return
        try:
            taken = port.write(data)
        except OSError as error:
            self._lose(error)
            return
        self._bytes_out += taken
        if taken == len(data):
            self._refused_in_a_row = 0
            return
        self._refused += 1
        self._refused_in_a_row += 1
        if self._refused_in_a_row > self.settings.max_refused:
            self._latch(
                "the serial port takes no bytes any more; the adapter hangs",
                f"{self._refused_in_a_row} cycles refused",
                f"{self.settings.max_refused} cycles in a row",
            )

    def _lose(self, error: OSError) -> None:
        self._latch(
            f"the serial adapter is gone while in use ({error}); was it pulled out?",
            self.settings.port,
            None,
        )

    def _latch(self, what: str, value: str, bound: str | None) -> None:
        if self._trouble is None:
            self._trouble = DeviceFault(self.name, what, value=value, bound=bound)
