"""A serial line in virtual time: bytes take their time, and both ends share one wire."""

from collections.abc import Callable, Sequence

from drivers.dynamixel.settings import SerialBusSettings
from drivers.sim.dynamixel.chain import EmulatedChain
from drivers.sim.dynamixel.device import EmulatedDynamixel
from drivers.sim.dynamixel.framing import InstructionPacket, InstructionReader
from drivers.sim.simulated_bus import LossyBus

_BITS_PER_BYTE = 10


class MemoryPort:
    """The host's end of the line; has what the driver's bus wants of a port."""

    def __init__(self) -> None:
        self.written = b""
        self.waiting = b""
        self.plugged_in = True

    def read(self, size: int) -> bytes:
        """Return what has come."""
        self._check_plugged_in()
        data, self.waiting = self.waiting[:size], self.waiting[size:]
        return data

    def write(self, data: bytes) -> int:
        """Take bytes to be sent."""
        self._check_plugged_in()
        self.written += data
        return len(data)

    def close(self) -> None:
        """Forget what is on the way."""
        self.written = self.waiting = b""

    def _check_plugged_in(self) -> None:
        if not self.plugged_in:
            raise OSError(5, "Input/output error")


def make_line(
    name: str, settings: SerialBusSettings, nodes: Sequence[EmulatedDynamixel]
) -> "EmulatedSerialBus":
    """Make the simulated end of a bus with these settings."""
    return EmulatedSerialBus(name, settings.baudrate, nodes)


class EmulatedSerialBus(LossyBus):
    """The simulated end of one serial bus, with the devices on it; part of an `EmulatedRig`.

    Parameters
    ----------
    name : str
        The bus's name in the profile.
    baudrate : int
        bit/s.
    nodes : sequence of EmulatedDynamixel
        The devices, whose servos have different ids.

    Attributes
    ----------
    port : MemoryPort
        The host's end.
    collisions : int
        How often the host spoke while a servo did.
    monitor : callable or None
        Takes time (s) and bytes of everything that is sent, both ways.

    Raises
    ------
    ValueError
        Two servos have the same id.
    """

    def __init__(self, name: str, baudrate: int, nodes: Sequence[EmulatedDynamixel]) -> None:
        super().__init__(name)
        self.nodes = tuple(nodes)
        self.port = MemoryPort()
        self.collisions = 0
        self.monitor: Callable[[float, bytes], None] | None = None
        self.chain = EmulatedChain([station for node in nodes for station in node.stations])
        self._byte_time = _BITS_PER_BYTE / baudrate
        self._reader = InstructionReader()
        self._talking_until = -1.0
        self._host_until = -1.0
        self._undisturbed = [True]  # of the last answer

    def drain(self, latency: float) -> None:
        """Take what the host sent; it arrives `latency` (s) and its time on the wire later."""
        data, self.port.written = self.port.written, b""
        if not data:
            return
        start = max(self._now + latency, self._host_until)
        self._host_until = start + len(data) * self._byte_time
        if start < self._talking_until:
            self._collide()
            return
        for packet in self._reader.take(data):

            def arrive(now: float, packet: InstructionPacket = packet) -> None:
                self._arrive(packet, now)

            self._post(start - self._now + packet.end * self._byte_time, arrive)

    @property
    def due(self) -> float:
        """When a servo has something to do of itself, s."""
        return self.chain.due

    def tick(self, now: float) -> None:
        """Give the servos the time."""
        self._now = now
        if self.chain.due <= now:
            self.chain.tick(now)

    def tell(self, now: float) -> None:
        """Give the servos the time even if nothing is due."""
        self._now = now
        self.chain.tick(now)

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` accepts."""
        return (*super().known_faults, "unplugged", "plugged_in", "noise")

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault of the bus itself happen, one of `LossyBus` or another.

        ``unplugged`` pulls the adapter out, ``plugged_in`` puts it back; ``noise`` (value:
        bytes, default 32) sends bytes that mean nothing.
        """
        if fault in ("unplugged", "plugged_in"):
            self.port.plugged_in = fault == "plugged_in"
        elif fault == "noise":
            count = 32 if value is None else int(value)
            self.port.waiting += self._random.randbytes(count)
        else:
            super().inject(fault, value)

    def _arrive(self, packet: InstructionPacket, now: float) -> None:
        self._now = now
        if self._lost():
            return
        answer = self.chain.handle(packet, now)
        if not answer or self._lost():
            return
        delay = len(answer) * self._byte_time
        self._talking_until = now + delay
        undisturbed = self._undisturbed = [True]
        if now < self._host_until:
            self._collide()

        def deliver(then: float) -> None:
            if not self.port.plugged_in:
                return
            if self.monitor is not None:
                self.monitor(then, answer)
            heard = answer if undisturbed[0] else bytes(byte & 0x5A for byte in answer)
            self.port.waiting += heard

        self._post(delay, deliver)

    def _collide(self) -> None:
        """Both ends speak: what the servo says is garbled."""
        self.collisions += 1
        self._undisturbed[0] = False
