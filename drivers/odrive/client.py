"""Ask an ODrive axis and tell it things, outside of the cycle.

CANSimple confirms nothing but parameters (SDO) and states (heartbeat): what can be read back
is read back.
"""

import struct
from collections.abc import Callable
from functools import partial
from math import inf
from typing import Final

from drivers.odrive.bus import OdriveBus
from drivers.odrive.codec import (
    BROADCAST,
    AxisState,
    Command,
    Heartbeat,
    Version,
    can_id,
    decode_address,
    decode_error,
    decode_heartbeat,
    decode_sdo,
    decode_version,
    describe_axis_state,
    describe_errors,
    encode_axis_state,
    encode_sdo_read,
    encode_sdo_write,
)
from rig.hal import ConnectionFailed

_ATTEMPTS: Final = 3
_OLDEST: Final = (0, 6)  # firmware with this CANSimple


class OdriveClient:
    """The master's side of one axis, as far as configuration goes.

    Parameters
    ----------
    name : str
        Device and joint, for messages.
    node : int
        The axis's number.
    bus : OdriveBus
        It is subscribed there.

    Attributes
    ----------
    heartbeat : Heartbeat or None
        The last one.
    heartbeats : int
        How many came.
    heard : float
        When the last one came, s.
    serials : set of int
        Serial numbers of all that answered under this number.
    written : dict
        Parameters that were written and read back, by their names.
    firmware : tuple of int
        As it was read.
    failed : callable
        Takes what is wrong, and `object`, `value` and `bound`; returns the error for the axis.
    """

    def __init__(self, name: str, node: int, bus: OdriveBus) -> None:
        self.name = name
        self.node = node
        self.failed = partial(ConnectionFailed, name, node=node)
        self.heartbeat: Heartbeat | None = None
        self.heartbeats = 0
        self.heard = -inf
        self.serials: set[int] = set()
        self.written: dict[str, float] = {}
        self.firmware = (0, 0, 0)
        self._bus = bus
        self._answers: dict[Command, bytes] = {}
        bus.subscribe(can_id(node, Command.HEARTBEAT), self._on_heartbeat)
        bus.subscribe(can_id(node, Command.ADDRESS), self._on_address)
        for command in (Command.GET_VERSION, Command.GET_ERROR):
            bus.subscribe(can_id(node, command), self._keeper(command, 8))
        # A value may be as long as its type, and a confirmation has none.
        bus.subscribe(can_id(node, Command.TX_SDO), self._keeper(Command.TX_SDO, 4))

    # What comes -----------------------------------------------------------------------

    def _on_heartbeat(self, data: bytes, now: float) -> None:
        if not 7 <= len(data) <= 8:
            return
        self.heartbeat = decode_heartbeat(data)
        self.heartbeats += 1
        self.heard = now

    def _on_address(self, data: bytes, now: float) -> None:
        if len(data) >= 7:
            _, serial = decode_address(data)
            self.serials.add(serial)

    def _keeper(self, command: Command, least: int) -> Callable[[bytes, float], None]:
        def keep(data: bytes, now: float) -> None:
            if least <= len(data) <= 8:
                self._answers[command] = data

        return keep

    @property
    def state(self) -> int:
        """The state of the last heartbeat."""
        return AxisState.UNDEFINED if self.heartbeat is None else self.heartbeat.state

    @property
    def errors(self) -> int:
        """The error flags of the last heartbeat."""
        return 0 if self.heartbeat is None else self.heartbeat.errors

    def describe(self) -> str:
        """Return errors and state in words."""
        return (
            f"{describe_errors(self.errors)} (errors 0x{self.errors:08X}), "
            f"axis state {self.state} ({describe_axis_state(self.state)})"
        )

    # What is asked --------------------------------------------------------------------

    def send(self, command: Command, data: bytes) -> None:
        """Send a command.

        Raises
        ------
        ConnectionFailed
            The interface refuses it.
        """
        self._try(lambda: self._bus.send(can_id(self.node, command), data))

    def wait_for_heartbeat(self) -> None:
        """Wait for the next heartbeat.

        Raises
        ------
        ConnectionFailed
            None comes.
        """
        bus = self._bus
        bus.receive(bus.clock.now())  # what waits already may be old
        before = self.heartbeats
        if not bus.wait_until(lambda: self.heartbeats > before, bus.settings.boot_timeout):
            raise self.failed(
                "no heartbeat comes; is it powered, and are its node number, the bit rate and "
                "heartbeat_msg_rate_ms right?",
                object="Heartbeat",
            )

    def read_version(self) -> Version:
        """Ask for the version and refuse firmware that speaks otherwise.

        Raises
        ------
        ConnectionFailed
            It is older than 0.6, or says nothing.
        """
        data = self._ask(Command.GET_VERSION)
        if data is None:
            raise self.failed(
                "it does not say its version; firmware before 0.6 does not, and means other "
                "things by the same frames: update it",
                object="Get_Version",
                bound="firmware 0.6 or later",
            )
        version = decode_version(data)
        self.firmware = version.firmware
        if version.firmware[:2] < _OLDEST:
            raise self.failed(
                "its firmware means other things by the same frames: update it",
                object="Get_Version",
                value="firmware " + ".".join(map(str, version.firmware)),
                bound="0.6 or later",
            )
        return version

    def read_errors(self) -> tuple[int, int]:
        """Return the active errors, and why the axis was disarmed last.

        Raises
        ------
        ConnectionFailed
            It does not answer.
        """
        data = self._ask(Command.GET_ERROR)
        if data is None:
            raise self.failed("it does not answer", object="Get_Error")
        return decode_error(data)

    def compare_serial(self, expected: int | None) -> None:
        """Refuse two axes with one number, and another serial number than the profile's.

        Raises
        ------
        ConnectionFailed
            One of the two.
        """
        if len(self.serials) > 1:
            found = ", ".join(f"{serial:012X}" for serial in sorted(self.serials))
            raise self.failed(
                f"{len(self.serials)} ODrives have this node number", object="Address", value=found
            )
        if expected is not None and self.serials != {expected}:
            raise self.failed(
                "its serial number is not the profile's",
                object="Address",
                value=next((f"{serial:012X}" for serial in self.serials), "no answer"),
                bound=f"{expected:012X}",
            )

    def enter(self, state: AxisState) -> None:
        """Request a state and wait until a heartbeat confirms it.

        Raises
        ------
        ConnectionFailed
            None does.
        """
        bus = self._bus
        for _ in range(_ATTEMPTS):
            before = self.heartbeats
            self.send(Command.SET_AXIS_STATE, encode_axis_state(state))
            if bus.wait_until(
                lambda before=before: self.heartbeats > before and self.state == state,  # type: ignore[misc]
                bus.settings.boot_timeout / _ATTEMPTS,
            ):
                return
        raise self.failed(
            "it does not enter the state that it was told",
            object="Set_Axis_State",
            value=describe_axis_state(self.state),
            bound=describe_axis_state(state),
        )

    def clear_errors(self) -> None:
        """Clear the errors and wait until a heartbeat shows none.

        Raises
        ------
        ConnectionFailed
            They stay.
        """
        before = self.heartbeats
        self.send(Command.CLEAR_ERRORS, bytes(1))
        if not self._bus.wait_until(
            lambda: self.heartbeats > before and not self.errors, self._bus.settings.boot_timeout
        ):
            raise self.failed(f"its errors stay: {self.describe()}", object="Clear_Errors")

    def write_parameter(self, endpoint: int, what: str, value: float, layout: str) -> None:
        """Write a parameter, read it back and compare.

        Parameters
        ----------
        endpoint : int
            Its number in this firmware.
        what : str
            Its name, for messages.
        value : float
            Its value.
        layout : str
            `struct` code of its type: ``?``, ``f``, ``I``.

        Raises
        ------
        ConnectionFailed
            It does not answer, or keeps another value.
        """
        packed = struct.pack(f"<{layout}", value if layout == "f" else int(value))
        self.send(Command.RX_SDO, encode_sdo_write(endpoint, packed))
        thing = f"endpoint {endpoint} ({what})"
        kept = b""
        for _ in range(_ATTEMPTS):
            self._answers.pop(Command.TX_SDO, None)
            self.send(Command.RX_SDO, encode_sdo_read(endpoint))
            # Firmware 0.6.11 and later confirms the write by a TxSdo too, which may come first.
            if self._bus.wait_until(
                lambda: self._kept(endpoint, len(packed)) == packed,
                self._bus.settings.reply_timeout,
            ):
                self.written[what] = float(value)
                return
            kept = self._kept(endpoint, len(packed)) or kept
        if not kept:
            raise self.failed("a parameter cannot be read back", object=thing)
        raise self.failed(
            "it took a setting but reads back another; it must not be used like this",
            object=thing,
            value=str(struct.unpack(f"<{layout}", kept)[0]),
            bound=str(struct.unpack(f"<{layout}", packed)[0]),
        )

    def request_parameter(self, endpoint: int) -> None:
        """Ask for a parameter, which `answered` tells when it has come."""
        self._answers.pop(Command.TX_SDO, None)
        self.send(Command.RX_SDO, encode_sdo_read(endpoint))

    def answered(self, endpoint: int, size: int) -> bytes:
        """Return the value of the parameter that was asked for last; empty while none came."""
        return self._kept(endpoint, size)

    def ask_all(self, command: Command) -> None:
        """Ask every axis of the bus with one frame; their answers come as they come.

        Raises
        ------
        ConnectionFailed
            The interface refuses it.
        """
        self._try(lambda: self._bus.request(can_id(BROADCAST, command)))

    # Inside ---------------------------------------------------------------------------

    def _ask(self, command: Command) -> bytes | None:
        bus = self._bus
        for _ in range(_ATTEMPTS):  # a frame may get lost
            self._answers.pop(command, None)
            self._try(lambda: bus.request(can_id(self.node, command)))
            if bus.wait_until(lambda: command in self._answers, bus.settings.reply_timeout):
                return self._answers[command]
        return None

    def _kept(self, endpoint: int, size: int) -> bytes:
        """Return the value that the last answer bears, if it is of this parameter."""
        number, value = decode_sdo(self._answers.get(Command.TX_SDO, bytes(4)))
        return value[:size] if number == endpoint and len(value) >= size else b""

    def _try(self, action: Callable[[], None]) -> None:
        try:
            action()
        except Exception as error:  # OSError or the interface's own
            raise self.failed(f"the interface refused a frame: {error}") from error
