"""Bring one CANopen node up, watch it, and never use it in a state that nobody chose.

References
----------
CiA 301 V4.2, sections 7.2.2 (PDO), 7.2.8 (NMT), 7.5.2 (communication objects).
"""

import struct
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any, Final, TypeVar

from drivers.can.milliseconds import to_milliseconds
from drivers.canopen.asked import AskedObjects
from drivers.canopen.bus import CanopenBus
from drivers.canopen.emergency import EmergencyLatch, describe_register
from drivers.canopen.heartbeat import HeartbeatWatch, NmtState, describe_state
from drivers.canopen.mapping import MAX_PDOS, SIZES, STRUCT_CODES, Layout
from rig.hal import ConnectionFailed, DeviceFault

_START: Final = 0x01
_STOP: Final = 0x02
_PRE_OPERATIONAL: Final = 0x80
_RESET_NODE: Final = 0x81
_ATTEMPTS: Final = 3

_INVALID: Final = 0x8000_0000  # bit 31 of a PDO's identifier
_KEEP: Final = 0x4000_0000  # bit 30: no remote requests; as the device has it
_SYNCHRONOUS: Final = 1
_ABSENT: Final = (0x0602_0000, 0x0609_0011)  # abort codes: no such object, no such sub-index
_RECEIVE, _TRANSMIT = 0x1400, 0x1800
_MAPPING_OFFSET: Final = 0x200

Result = TypeVar("Result")


class CanopenNode:
    """The master's side of one node.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    node : int
        Its number, 1 … 127.
    bus : CanopenBus
        The bus that it hangs on.

    Attributes
    ----------
    failed : callable
        Takes what is wrong, and `object`, `value` and `bound`; returns the error for the node.
    """

    def __init__(self, name: str, node: int, bus: CanopenBus) -> None:
        self.name = name
        self.node = node
        self.failed = partial(ConnectionFailed, name, node=node)
        self.heartbeat = HeartbeatWatch(name, node, bus.settings.heartbeat_timeout)
        self.emergency = EmergencyLatch()
        self._bus = bus
        self.written: dict[str, float] = {}
        """What was written since `connect` and read back, raw, by its object."""
        self._sdo: Any = None
        self._armed = False
        bus.subscribe(0x700 + node, self.heartbeat.receive)
        bus.subscribe(0x080 + node, self.emergency.receive)
        self.asked = AskedObjects(self._send, node)
        bus.subscribe(0x580 + node, self._take_answer)

    # Life cycle -----------------------------------------------------------------------

    def connect(
        self,
        *,
        profile: int,
        vendor: int | None = None,
        product: int | None = None,
        serial: int | None = None,
    ) -> int:
        """Reset the node and leave it in PRE-OPERATIONAL, identified and with heartbeats.

        Parameters
        ----------
        profile : int
            CiA device profile, e.g. 401.
        vendor, product, serial : int, optional
            What 0x1018 must say.

        Returns
        -------
        int
            The upper word of the device type, which says what of the profile it has.

        Raises
        ------
        ConnectionFailed
            It does not answer, is another device, reports an error, or does not take a
            setting.
        """
        self.disarm()
        self.written.clear()
        if self._sdo is None:
            self._sdo = self._bus.network.add(self.node)
        self._reset()
        device_type = self._identify(profile)
        self._compare_identity(vendor=vendor, product=product, serial=serial)
        register = self.read(0x1001, 0, "u8")
        if register:
            raise self.failed(
                "it reports an error before it is used",
                object="0x1001:00",
                value=f"0x{register:02X} ({describe_register(int(register))})",
            )
        settings = self._bus.settings
        self.write(0x1017, 0, "u16", to_milliseconds(settings.heartbeat))
        timeout = to_milliseconds(settings.heartbeat_timeout)
        self.write(0x1016, 1, "u32", settings.master_id << 16 | timeout)
        self._check_alone()
        return device_type >> 16

    def map_pdos(
        self, receive: Sequence[Layout], transmit: Sequence[Layout], *, remap: bool
    ) -> None:
        """Set up the PDOs, all synchronous, and switch off those that are not used.

        Parameters
        ----------
        receive, transmit : sequence of Layout
            What the node receives and sends, from PDO 1 on.
        remap : bool
            Write the mapping, else compare it.

        Raises
        ------
        ConnectionFailed
            A PDO is missing, or does not take its mapping.
        """
        for base, layouts in ((_RECEIVE, receive), (_TRANSMIT, transmit)):
            for number in range(MAX_PDOS):
                layout = layouts[number] if number < len(layouts) else None
                if layout is None:
                    self._switch_off(base + number)
                else:
                    default = (0x200 if base == _RECEIVE else 0x180) + 0x100 * number
                    self._map(base + number, default + self.node, layout, remap=remap)

    def set_deadlines(self, count: int, deadline: float | None) -> None:
        """Let its first receive PDOs stay away for so long (s), once they have come."""
        if deadline is not None:
            for number in range(count):
                self.write(_RECEIVE + number, 5, "u16", to_milliseconds(deadline))

    def arm(self) -> None:
        """Start the node and wait until its heartbeat says OPERATIONAL.

        Raises
        ------
        ConnectionFailed
            It does not, or reported an emergency since it was connected.
        """
        watch, emergency = self.heartbeat, self.emergency
        boots = watch.boots
        watch.forget()  # only a heartbeat from now on counts
        for _ in range(_ATTEMPTS):  # the command may get lost; it is not confirmed
            self._command(_START)
            if self._bus.wait_until(
                lambda: watch.state == NmtState.OPERATIONAL or emergency.active is not None,
                self._bus.settings.boot_timeout / _ATTEMPTS,
            ):
                break
        if emergency.active is not None:
            raise self.failed(str(emergency.active))
        if watch.state != NmtState.OPERATIONAL or watch.boots != boots:
            raise self.failed(
                "it did not enter OPERATIONAL",
                value=describe_state(watch.state),
                bound="OPERATIONAL",
            )
        watch.arm()
        self._armed = True

    def halt(self) -> None:
        """Stop the node: it ignores setpoints and does what it was told for that. Never raises."""
        with suppress(ConnectionFailed):
            self._command(_STOP)

    def disarm(self) -> None:
        """Expect nothing of the node any more."""
        self._armed = False
        self.heartbeat.disarm()

    def check(self, now: float) -> None:
        """Raise if the armed node is not well.

        Raises
        ------
        DeviceFault
            It reported an emergency, rebooted, left OPERATIONAL or fell silent.
        """
        if not self._armed:
            return
        if self.emergency.active is not None:
            raise DeviceFault(self.name, str(self.emergency.active), node=self.node)
        if now > self.heartbeat.good_until:
            self.heartbeat.check(now)

    # Objects --------------------------------------------------------------------------

    def read(self, index: int, sub: int, type: str) -> int | float:
        """Read an object.

        Raises
        ------
        ConnectionFailed
            The node refuses, does not answer, or has the object in another size.
        """
        data = self._transfer("read", index, sub, lambda: self._sdo.upload(index, sub))
        if len(data) != SIZES[type]:
            raise self.failed(
                "an object has another size than its type",
                object=f"0x{index:04X}:{sub:02X}",
                value=f"{len(data)} bytes",
                bound=f"{SIZES[type]} bytes ({type})",
            )
        value: int | float = struct.unpack("<" + STRUCT_CODES[type], data)[0]
        return value

    def read_if_present(self, index: int, sub: int, type: str) -> int | float | None:
        """Read an object that a node need not have; None if it has not."""
        try:
            return self.read(index, sub, type)
        except ConnectionFailed as error:
            from canopen import SdoAbortedError

            cause = error.__cause__
            if isinstance(cause, SdoAbortedError) and cause.code in _ABSENT:
                return None
            raise

    def write(
        self, index: int, sub: int, type: str, value: float, *, mask: int | None = None
    ) -> None:
        """Write an object, read it back and compare.

        Parameters
        ----------
        index, sub : int
            The object.
        type : str
            Its data type.
        value : int or float
            Raw.
        mask : int, optional
            Compare only these bits.

        Raises
        ------
        ConnectionFailed
            The node refuses, does not answer, or does not keep the value.
        """
        data = struct.pack("<" + STRUCT_CODES[type], value if type == "f32" else int(value))
        self._transfer("written", index, sub, lambda: self._sdo.download(index, sub, data))
        kept = self.read(index, sub, type)
        expected = struct.unpack("<" + STRUCT_CODES[type], data)[0]
        if not (kept == expected if mask is None else int(kept) & mask == int(expected) & mask):
            raise self.failed(
                "it took a setting but reads back another; it must not be used like this",
                object=f"0x{index:04X}:{sub:02X}",
                value=_show(kept),
                bound=_show(expected),
            )
        self.written[f"0x{index:04X}:{sub:02X}"] = kept

    # Inside ---------------------------------------------------------------------------

    def _take_answer(self, data: bytes, now: float) -> None:
        if not self.asked.take(data, now):
            self._bus.network.take_answer(0x580 + self.node, data, now)

    def _reset(self) -> None:
        """Reset the node, so that it starts from its power-on state whatever went before."""
        watch = self.heartbeat
        boots = watch.boots
        self._command(_RESET_NODE)
        if not self._bus.wait_until(lambda: watch.boots != boots, self._bus.settings.boot_timeout):
            # Its boot-up may have been lost; whoever answers is there.
            self._command(_PRE_OPERATIONAL)
        self.emergency.clear()

    def _check_alone(self) -> None:
        """Raise if more answers came than there were questions, but for a stray one."""
        surplus = self._bus.network.surplus(self.node)
        if surplus > 1:
            raise self.failed(
                "several devices have this node number; take all but one off the bus, and give "
                "them others",
                value=f"{surplus} answers more than there were questions",
            )

    def _identify(self, profile: int) -> int:
        device_type = int(self.read(0x1000, 0, "u32"))
        if device_type & 0xFFFF != profile:
            raise self.failed(
                "it is another kind of device",
                object="0x1000:00",
                value=f"CiA {device_type & 0xFFFF} (0x{device_type:08X})",
                bound=f"CiA {profile}",
            )
        return device_type

    def _compare_identity(self, **wanted: int | None) -> None:
        for sub, what in ((1, "vendor"), (2, "product"), (4, "serial")):
            expected = wanted[what]
            if expected is None:
                continue
            found = self.read(0x1018, sub, "u32")
            if found != expected:
                raise self.failed(
                    f"its {what} number is not the profile's",
                    object=f"0x1018:{sub:02X}",
                    value=_show(found),
                    bound=_show(expected),
                )

    def _map(self, communication: int, can_id: int, layout: Layout, *, remap: bool) -> None:
        mapping = communication + _MAPPING_OFFSET
        keep = int(self.read(communication, 1, "u32")) & _KEEP
        self.write(communication, 1, "u32", _INVALID | keep | can_id, mask=_INVALID)
        if remap:
            self.write(mapping, 0, "u8", 0)
            for sub, entry in enumerate(layout, 1):
                self.write(mapping, sub, "u32", entry.code)
            self.write(mapping, 0, "u8", len(layout))
        else:
            self._compare_mapping(mapping, layout)
        self.write(communication, 2, "u8", _SYNCHRONOUS)
        self.write(communication, 1, "u32", keep | can_id)

    def _compare_mapping(self, mapping: int, layout: Layout) -> None:
        count = int(self.read(mapping, 0, "u8"))
        found = [int(self.read(mapping, sub, "u32")) for sub in range(1, count + 1)]
        expected = [entry.code for entry in layout]
        if found != expected:
            raise self.failed(
                "its fixed mapping is not what the profile needs",
                object=f"0x{mapping:04X}",
                value=" ".join(f"{code:08X}" for code in found) or "nothing",
                bound=" ".join(f"{code:08X}" for code in expected),
            )

    def _switch_off(self, communication: int) -> None:
        can_id = self.read_if_present(communication, 1, "u32")
        if can_id is not None and not int(can_id) & _INVALID:
            self.write(communication, 1, "u32", int(can_id) | _INVALID, mask=_INVALID)

    def _command(self, command: int) -> None:
        self._send(0x000, bytes((command, self.node)))

    def _send(self, can_id: int, data: bytes) -> None:
        try:
            self._bus.send(can_id, data)
        except Exception as error:
            raise self.failed(f"the interface refused a frame: {error}") from error

    def _transfer(self, done: str, index: int, sub: int, action: Callable[[], Result]) -> Result:
        from canopen import SdoAbortedError

        thing = f"0x{index:04X}:{sub:02X}"
        try:
            return action()
        except SdoAbortedError as error:
            text = SdoAbortedError.CODES.get(error.code, "unknown reason")
            raise self.failed(
                f"it refused to have an object {done}: {text} (abort 0x{error.code:08X})",
                object=thing,
            ) from error
        except (ConnectionFailed, DeviceFault):
            raise
        except Exception as error:  # no answer, a broken answer, or a refused frame
            self._check_alone()
            raise self.failed(
                f"it did not answer when an object was to be {done} ({error}); "
                "is it powered, and are its node number and bit rate right?",
                object=thing,
            ) from error


def pdo_id(number: int, node: int) -> int:
    """Return the identifier of a node's receive PDO, in the pre-defined connection set."""
    return 0x100 + 0x100 * number + node


def _show(value: float) -> str:
    return f"{value:g}" if isinstance(value, float) else f"{value} (0x{value & 0xFFFFFFFF:X})"
