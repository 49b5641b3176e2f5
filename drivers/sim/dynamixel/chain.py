"""Servos on one half-duplex line: who answers what, when, and what goes wrong on the wire."""

from collections.abc import Callable, Sequence
from math import inf

from drivers.sim.dynamixel import framing
from drivers.sim.dynamixel.framing import InstructionPacket
from drivers.sim.dynamixel.servo import EmulatedServo

Distortion = Callable[[bytes], bytes]


class Station:
    """One servo on the line, and what happens to what it says.

    Attributes
    ----------
    twin : EmulatedServo or None
        A second servo with the same id, which speaks at the same time.
    """

    def __init__(self, servo: EmulatedServo) -> None:
        self.servo = servo
        self.twin: EmulatedServo | None = None
        self._now = 0.0
        self._silent_until = -inf
        self._distortion: Distortion | None = None
        self._distorted_until = -inf
        self._deaf_until = -inf

    def servos(self) -> tuple[EmulatedServo, ...]:
        """Return who answers here."""
        return (self.servo,) if self.twin is None else (self.servo, self.twin)

    def tick(self, now: float) -> None:
        """Let time pass."""
        self._now = now
        for servo in self.servos():
            servo.tick(now)

    @property
    def is_connected(self) -> bool:
        """Return whether anything is heard and said here."""
        return self._now >= self._silent_until

    @property
    def is_deaf(self) -> bool:
        """Return whether what is written to several servos at once does not reach this one."""
        return self._now < self._deaf_until

    def say(self, answers: Sequence[bytes]) -> bytes:
        """Return what is heard when all who are here speak at once."""
        said = answers[0]
        for other in answers[1:]:
            said = _overlay(said, other)
        if self._distortion is not None and self._now < self._distorted_until:
            return self._distortion(said)
        return said

    def silence(self, duration: float) -> None:
        """Cut the servo off for so long, s."""
        self._silent_until = self._now + duration

    def deafen(self, duration: float) -> None:
        """Have what is written to several servos at once pass it by for so long, s."""
        self._deaf_until = self._now + duration

    def distort(self, distortion: Distortion, duration: float) -> None:
        """Change what it says for so long, s."""
        self._distortion, self._distorted_until = distortion, self._now + duration

    def repair(self) -> None:
        """Put everything on the line right."""
        self._silent_until = self._distorted_until = self._deaf_until = -inf
        self.twin = None


class EmulatedChain:
    """All servos on one line.

    Parameters
    ----------
    stations : sequence of Station
        With different ids.
    """

    def __init__(self, stations: Sequence[Station]) -> None:
        self.stations = tuple(stations)
        self._by_id = {station.servo.id: station for station in self.stations}
        if len(self._by_id) != len(self.stations):
            ids = [station.servo.id for station in self.stations]
            raise ValueError(f"two servos have the same id: {ids}; use twin for that")

    @property
    def due(self) -> float:
        """Return when a servo has something to do, s."""
        return min(
            (servo.due for station in self.stations for servo in station.servos()),
            default=inf,
        )

    def tick(self, now: float) -> None:
        """Let time pass."""
        for station in self.stations:
            station.tick(now)

    def handle(self, packet: InstructionPacket, now: float) -> bytes:
        """Do what a packet asks, and return what then goes over the line.

        A servo that is to answer after another one waits until it has heard it.
        """
        self.tick(now)
        for station in self.stations:
            if station.is_connected and packet.servo in (station.servo.id, framing.BROADCAST):
                for servo in station.servos():
                    servo.hear(now)
        if packet.servo == framing.BROADCAST:
            return self._handle_all(packet, now) if packet.intact else b""
        addressed = self._station(packet.servo)
        if addressed is None:
            return b""
        answers = [self._answer(servo, packet, now) for servo in addressed.servos()]
        return addressed.say(answers)

    # One servo ------------------------------------------------------------------------

    def _answer(self, servo: EmulatedServo, packet: InstructionPacket, now: float) -> bytes:
        data = b""
        parameters = packet.parameters
        instruction = packet.instruction
        if not packet.intact:
            error = framing.WRONG_CRC
        elif instruction == framing.PING:
            error, data = 0, servo.identity()
        elif instruction == framing.READ and len(parameters) == 4:
            error, data = servo.read(*_numbers(parameters), now)
        elif instruction == framing.WRITE and len(parameters) > 2:
            error = servo.write(_number(parameters), parameters[2:])
        elif instruction == framing.REG_WRITE and len(parameters) > 2:
            error = servo.register(_number(parameters), parameters[2:])
        elif instruction == framing.ACTION:
            done = servo.act()
            error = framing.UNKNOWN_INSTRUCTION if done is None else done
        elif instruction == framing.REBOOT:
            error = 0
            servo.reboot()
        else:
            error = framing.UNKNOWN_INSTRUCTION
        if not self._may_answer(servo, instruction):
            return b""
        return framing.build_status(servo.id, error | servo.alert, data)

    def _may_answer(self, servo: EmulatedServo, instruction: int) -> bool:
        level = servo.read(68, 1, 0.0)[1][0]  # Status Return Level
        return instruction == framing.PING or level >= (1 if instruction == framing.READ else 2)

    def _station(self, servo: int) -> Station | None:
        station = self._by_id.get(servo)
        return station if station is not None and station.is_connected else None

    # All servos -----------------------------------------------------------------------

    def _handle_all(self, packet: InstructionPacket, now: float) -> bytes:
        parameters = packet.parameters
        match packet.instruction:
            case framing.PING:
                present = [station for station in self.stations if station.is_connected]
                present.sort(key=lambda station: station.servo.id)
                return b"".join(
                    s.say([self._answer(servo, packet, now) for servo in s.servos()])
                    for s in present
                )
            case framing.WRITE if len(parameters) > 2:
                self._for_all(lambda servo: servo.write(_number(parameters), parameters[2:]))
            case framing.REG_WRITE if len(parameters) > 2:
                self._for_all(lambda servo: servo.register(_number(parameters), parameters[2:]))
            case framing.ACTION:
                self._for_all(EmulatedServo.act)
            case framing.REBOOT:
                self._for_all(EmulatedServo.reboot)
            case framing.SYNC_WRITE if len(parameters) > 4:
                self._write_each(parameters)
            case framing.SYNC_READ if len(parameters) > 4:
                address, size = _numbers(parameters)
                return self._read_each([(servo, address, size) for servo in parameters[4:]], now)
            case framing.BULK_READ if len(parameters) % 5 == 0:
                wanted = [parameters[k : k + 5] for k in range(0, len(parameters), 5)]
                return self._read_each([(part[0], *_numbers(part[1:])) for part in wanted], now)
            case framing.FAST_SYNC_READ if len(parameters) > 4:
                return self._read_together(*_numbers(parameters), parameters[4:], now)
        return b""

    def _for_all(self, action: Callable[[EmulatedServo], object]) -> None:
        for station in self.stations:
            if station.is_connected:
                for servo in station.servos():
                    action(servo)

    def _write_each(self, parameters: bytes) -> None:
        address, size = _numbers(parameters)
        stride = size + 1
        for at in range(4, len(parameters) - size, stride):
            station = self._station(parameters[at])
            if station is not None and not station.is_deaf:
                for servo in station.servos():
                    servo.write(address, parameters[at + 1 : at + stride])

    def _read_each(self, wanted: Sequence[tuple[int, int, int]], now: float) -> bytes:
        """Answer one after the other, each when it has heard the one before."""
        line = b""
        for number, address, size in wanted:
            station = self._station(number)
            if station is None:
                break
            answers = []
            for servo in station.servos():
                error, data = servo.read(address, size, now)
                answers.append(framing.build_status(servo.id, error | servo.alert, data))
            said = station.say(answers)
            line += said
            if len(said) < len(answers[0]):
                break
        return line

    def _read_together(self, address: int, size: int, servos: bytes, now: float) -> bytes:
        """Answer in one packet, each its block, when it has heard all that comes before."""
        line = framing.begin_common_status(size, len(servos))
        heard = framing.checksum(line)
        for k, number in enumerate(servos):
            station = self._station(number)
            if station is None:
                return line if k else b""  # the first one's header comes with its block
            blocks = []
            for servo in station.servos():
                error, data = servo.read(address, size, now)
                error |= servo.alert
                blocks.append(framing.build_block(heard, servo.id, error, data or bytes(size)))
            said = station.say(blocks)[: len(blocks[0])]  # its place ends here
            line += said
            if len(said) < len(blocks[0]):
                break
            heard = framing.checksum(said, heard)
        return line


def _overlay(one: bytes, other: bytes) -> bytes:
    """Return what two who speak at once make of the line: a 0 beats a 1."""
    longer, shorter = (one, other) if len(one) >= len(other) else (other, one)
    return bytes(a & b for a, b in zip(longer, shorter, strict=False)) + longer[len(shorter) :]


def _number(data: bytes) -> int:
    return data[0] | data[1] << 8


def _numbers(data: bytes) -> tuple[int, int]:
    return data[0] | data[1] << 8, data[2] | data[3] << 8
