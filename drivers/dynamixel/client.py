"""One servo's registers, read and written with an answer: configuration, outside the cycle."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

from drivers.dynamixel.codec import BROADCAST_ID, Status, encode_ping, encode_read, encode_write
from drivers.dynamixel.registers import ALERT, Register, describe_status_error
from rig.hal import ConnectionFailed

SCAN_TIME: Final = 0.3  # s; servos answer a ping to all in turn, the one with id k after k ms

if TYPE_CHECKING:
    from drivers.dynamixel.bus import SerialBus


class Identity(NamedTuple):
    """The identity that a servo reports.

    Attributes
    ----------
    model : int
        Its model number.
    firmware : int
        The version of its firmware.
    """

    model: int
    firmware: int


class RegisterClient:
    """Reads and writes one servo's control table; asks again if a packet gets lost.

    Attributes
    ----------
    identity : Identity
        What it said of itself last.
    written : dict
        What registers were found to hold that had to hold it, by their names.
    """

    def __init__(self, device: str, joint: str, servo: int, bus: "SerialBus") -> None:
        self.device = device
        self.joint = joint
        self.servo = servo
        self._bus = bus
        self.identity = Identity(0, 0)
        self.written: dict[str, float] = {}

    def ping(self) -> Identity:
        """Ask who it is.

        Raises
        ------
        ConnectionFailed
            It does not answer, not in time, or not alone.
        """
        bound = self._bus.max_latency
        latency = bound
        for _ in range(2):  # a first answer may be slow because a packet got lost
            asked = self._bus.clock.now()
            self._ask(encode_ping(self.servo), 3, "ping")
            latency = self._bus.clock.now() - asked
            if latency <= bound:
                break
        if latency > bound:
            raise self.failed(
                "it answers too slowly for the cycle; set the adapter's latency timer to 1 ms "
                "and the servos' Return Delay Time (9) to 0",
                value=f"{latency * 1e3:.1f} ms",
                bound=f"{bound * 1e3:g} ms",
            )
        status = self._ask(encode_ping(self.servo), 3, "ping", alone=True)
        self.identity = Identity(status.data[0] | status.data[1] << 8, status.data[2])
        return self.identity

    def read(self, register: Register) -> int:
        """Read a register.

        Raises
        ------
        ConnectionFailed
            It refuses, or does not answer.
        """
        return register.decode(self.read_bytes(register.address, register.size, str(register)))

    def read_bytes(self, address: int, size: int, what: str) -> bytes:
        """Read registers that stand side by side."""
        return self._ask(encode_read(self.servo, address, size), size, what).data

    def write(self, register: Register, value: int) -> None:
        """Write a register, read it back and compare.

        Raises
        ------
        ConnectionFailed
            It refuses, does not answer, or does not keep the value.
        """
        self.command(register, value)
        kept = self.read(register)
        self._compare(kept, value, str(register))
        self.written[str(register)] = kept

    def settle(self, register: Register, value: int) -> None:
        """Have a register hold a value; write only if it does not, as in EEPROM it wears."""
        if self.read(register) != value:
            self.write(register, value)
        self.written[str(register)] = value

    def command(self, register: Register, value: int) -> None:
        """Write a register that cannot be compared afterwards."""
        self._ask(
            encode_write(self.servo, register.address, register.encode(value)), 0, str(register)
        )

    def write_bytes(self, address: int, data: bytes, what: str) -> None:
        """Write registers that stand side by side, read them back and compare."""
        self._ask(encode_write(self.servo, address, data), 0, what)
        kept = self.read_bytes(address, len(data), what)
        if kept != data:
            self._compare(int.from_bytes(kept, "little"), int.from_bytes(data, "little"), what)

    def failed(
        self,
        what: str,
        *,
        register: str | None = None,
        value: str | None = None,
        bound: str | None = None,
    ) -> ConnectionFailed:
        """Return an error that names the servo."""
        return ConnectionFailed(
            self.device,
            f"{self.joint} (id {self.servo}): {what}",
            node=self.servo,
            object=register,
            value=value,
            bound=bound,
        )

    def _ask(self, packet: bytes, size: int, what: str, *, alone: bool = False) -> Status:
        """Return the answer to a packet; with `alone`, listen whether a second one comes."""
        bus, servo = self._bus, self.servo
        settings = bus.settings
        wanted = 2 if alone else 1

        def is_enough(answers: Sequence[Status]) -> bool:
            return sum(status.id == servo for status in answers) >= wanted

        was_damaged = False
        for _ in range(settings.attempts):
            answers, damaged = bus.ask(packet, is_enough, settings.reply_timeout)
            was_damaged |= damaged
            mine = [status for status in answers if status.id == servo]
            if len(mine) > 1:
                raise self.failed("it answers twice; there are two servos with this id")
            if not mine:
                continue
            status = mine[0]
            error = status.error & ~ALERT
            if error:
                raise self.failed(
                    f"it refused: {describe_status_error(error)}",
                    register=what,
                    value=f"0x{status.error:02X}",
                )
            if len(status.data) == size:
                return status
            was_damaged = True
        if was_damaged:
            raise self.failed(
                "its answers are garbled; there are two servos with this id, or the cable is bad",
                register=what,
            )
        raise self.failed(f"it does not answer{self._others()}", register=what)

    def _others(self) -> str:
        """Return who else is on the chain, in words."""
        bus = self._bus
        found, _ = bus.ask(encode_ping(BROADCAST_ID), lambda answers: False, SCAN_TIME)
        if not found:
            return (
                f", nor does any servo at {bus.settings.baudrate} bit/s; look at the power, the "
                "cable and the baud rate"
            )
        ids = ", ".join(str(status.id) for status in sorted(found))
        return f"; on this chain answer: {ids}"

    def _compare(self, kept: int, expected: int, what: str) -> None:
        if kept != expected:
            raise self.failed(
                "it took a setting but reads back another; it must not be used like this",
                register=what,
                value=str(kept),
                bound=str(expected),
            )
