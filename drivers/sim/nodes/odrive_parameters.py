"""What a host reads, writes and calls of an emulated ODrive axis by RxSdo and TxSdo.

A frame names a parameter by its number. Two kinds of host ask: by the manual, with opcode 0 or 1
in the first byte; and the maker's own software since firmware 0.6.11, which puts the connection's
number (even, given by Address) around the opcode and a sequence number into the reserved byte,
and takes both back. The second kind is not in the manual: it is kept as `libodrive` 0.9.6 speaks
it, which asks endpoint 0 for a description of all others and then works with their names.

References
----------
ODrive Robotics, "CAN Protocol" of firmware 0.6; "Communication Protocol" of the open firmware 0.5
and its library Fibre: endpoint 0, JSON descriptor, its checksum.
"""

import json
import struct
from collections.abc import Callable, Mapping
from operator import attrgetter
from typing import Any, Final, NamedTuple

_HEAD: Final = struct.Struct("<BHB")  # connection and opcode, number, sequence
_WRITE: Final = 0x01
_CODES: Final = {"bool": "?", "uint8": "B", "uint32": "I", "float": "f"}
_DESCRIPTION: Final = 0  # the number of the JSON descriptor
_IDENTITY: Final = 0xFFFF_FFFF  # the offset in it at which its version is asked for
_CHUNK: Final = 4  # bytes of an answer in a frame
_POLYNOMIAL: Final = 0x3D65
_PROTOCOL: Final = 1  # what its checksum begins with
_CONFIRMS_SINCE: Final = (0, 6, 11)


class _Parameter(NamedTuple):
    """A value of the axis; it is written by `attribute`, if at all."""

    path: str
    type: str
    read: Callable[[Any], float]
    attribute: str | None = None


def _constant(path: str, read: Callable[[Any], float]) -> _Parameter:
    return _Parameter(path, "uint8", read)


def _state(path: str, kind: str, attribute: str) -> _Parameter:
    return _Parameter(path, kind, attrgetter(attribute))


def _setting(path: str, kind: str, attribute: str) -> _Parameter:
    return _Parameter(path, kind, attrgetter(attribute), attribute)


_PARAMETERS: Final = (
    _constant("hw_version_major", lambda axis: axis.hardware[0]),
    _constant("hw_version_minor", lambda axis: axis.hardware[1]),
    _constant("hw_version_variant", lambda axis: axis.hardware[2]),
    _constant("fw_version_major", lambda axis: axis.firmware[0]),
    _constant("fw_version_minor", lambda axis: axis.firmware[1]),
    _constant("fw_version_revision", lambda axis: axis.firmware[2]),
    _state("axis0.active_errors", "uint32", "active_errors"),
    _state("axis0.disarm_reason", "uint32", "disarm_reason"),
    _state("axis0.current_state", "uint8", "axis_state"),
    _setting("axis0.requested_state", "uint8", "requested_state"),
    _setting("axis0.config.enable_watchdog", "bool", "enable_watchdog"),
    _setting("axis0.config.watchdog_timeout", "float", "watchdog_timeout"),
    _setting("axis0.config.can.heartbeat_msg_rate_ms", "uint32", "heartbeat_msg_rate_ms"),
    _setting("axis0.config.can.encoder_msg_rate_ms", "uint32", "encoder_msg_rate_ms"),
    _setting("axis0.config.motor.current_soft_max", "float", "current_limit"),
    _setting("axis0.controller.config.vel_limit", "float", "speed_limit"),
    _setting("axis0.controller.config.control_mode", "uint8", "control_mode"),
    _setting("axis0.controller.config.input_mode", "uint8", "input_mode"),
)
_SAVED: Final = (
    "node_id",
    "enable_watchdog",
    "watchdog_timeout",
    "heartbeat_msg_rate_ms",
    "encoder_msg_rate_ms",
)
# By their paths; what reboots answers no more.
_FUNCTIONS: Final = ("clear_errors", "reboot", "save_configuration")
_REBOOTING: Final = ("reboot", "save_configuration")


class OdriveParameters:
    """The parameters and functions of one axis, by number.

    Parameters
    ----------
    axis : EmulatedOdrive
        Whose they are: the attributes above, `clear_errors`, `reboot`, `save_configuration`, and
        `apply_settings`, which is called after each write.
    numbers : mapping of str to int, optional
        Numbers of parameters, by path; the others are numbered from 1 on.
    """

    def __init__(self, axis: Any, numbers: Mapping[str, int]) -> None:
        self._axis = axis
        given = dict(numbers)
        taken = {*given.values(), _DESCRIPTION}
        free = (number for number in range(1, 1 << 16) if number not in taken)
        paths = (*(parameter.path for parameter in _PARAMETERS), *_FUNCTIONS)
        self.numbers = {path: given[path] if path in given else next(free) for path in paths}
        self._parameters = {self.numbers[p.path]: p for p in _PARAMETERS}
        self._functions = {self.numbers[path]: path for path in _FUNCTIONS}
        self._description = json.dumps(self._describe(), separators=(",", ":")).encode()
        self._last: tuple[bytes, bytes | None] = (b"", None)
        self._kept: dict[str, Any] = {}

    def save(self) -> None:
        """Keep the configuration as it is now."""
        self._kept = {name: getattr(self._axis, name) for name in _SAVED}

    def restore(self) -> None:
        """Set the configuration as it was kept."""
        for name, value in self._kept.items():
            setattr(self._axis, name, value)
        self._last = b"", None

    def take(self, data: bytes, connection: int) -> bytes | None:
        """Return what is sent by TxSdo after an RxSdo came, or None.

        Parameters
        ----------
        data : bytes
            Of the RxSdo, at least 4.
        connection : int
            The number of the connection that the axis has now; 0 if it has none.
        """
        head, number, sequence = _HEAD.unpack_from(data)
        asked_by = head & ~_WRITE
        if not asked_by:
            return self._take_by_manual(head, number, data[_HEAD.size :])
        if asked_by != connection or self._axis.firmware < _CONFIRMS_SINCE:
            return None
        if data == self._last[0]:  # asked again: the answer got lost, what was asked for is done
            return self._last[1]
        value = self._access(head & _WRITE, number, data[_HEAD.size :])
        answer = None if value is None else _HEAD.pack(head, number, sequence) + value
        self._last = data, answer
        return answer

    def _take_by_manual(self, opcode: int, number: int, given: bytes) -> bytes | None:
        value = self._access(opcode, number, given)
        if value is None or (opcode == _WRITE and self._axis.firmware < _CONFIRMS_SINCE):
            return None
        filled = value.ljust(_CHUNK, b"\0") if opcode != _WRITE else value
        return _HEAD.pack(0, number, 0) + filled

    def _access(self, opcode: int, number: int, given: bytes) -> bytes | None:
        """Read, write or call; return what comes of it, None for no answer at all."""
        if number == _DESCRIPTION:
            return self._read_description(given)
        if number in self._functions:
            path = self._functions[number]
            getattr(self._axis, path)()
            return None if path in _REBOOTING else b""
        parameter = self._parameters.get(number)
        if parameter is None:
            return None
        layout = f"<{_CODES[parameter.type]}"
        if opcode != _WRITE:
            return struct.pack(layout, parameter.read(self._axis))
        if parameter.attribute is None or len(given) < struct.calcsize(layout):
            return None
        setattr(self._axis, parameter.attribute, struct.unpack_from(layout, given)[0])
        self._axis.apply_settings()
        return b""

    # The descriptor -------------------------------------------------------------------

    def _read_description(self, given: bytes) -> bytes | None:
        if len(given) < 4:
            return None
        offset = int.from_bytes(given[:4], "little")
        if offset != _IDENTITY:
            return self._description[offset : offset + _CHUNK]
        checksum = _checksum(self._description, _PROTOCOL)
        return struct.pack("<HH", _checksum(self._description, checksum), checksum)

    def _describe(self) -> list[dict[str, Any]]:
        top: list[dict[str, Any]] = [
            {"name": "", "id": _DESCRIPTION, "type": "json", "access": "r"}
        ]
        for parameter in _PARAMETERS:
            *objects, name = parameter.path.split(".")
            members = top
            for called in objects:
                members = _members_of(members, called)
            access = "r" if parameter.attribute is None else "rw"
            number = self.numbers[parameter.path]
            members.append({"name": name, "id": number, "type": parameter.type, "access": access})
        for path in _FUNCTIONS:
            number = self.numbers[path]
            top.append(
                {"name": path, "id": number, "type": "function", "inputs": [], "outputs": []}
            )
        return top


def _members_of(members: list[dict[str, Any]], name: str) -> list[dict[str, Any]]:
    """Return the members of an object, which is made if there is none yet."""
    for member in members:
        if member["name"] == name:
            found: list[dict[str, Any]] = member["members"]
            return found
    made: dict[str, Any] = {"name": name, "type": "object", "members": []}
    members.append(made)
    return made["members"]  # type: ignore[no-any-return]


def _checksum(data: bytes, start: int) -> int:
    """Return Fibre's CRC-16, most significant bit first."""
    remainder = start
    for byte in data:
        remainder ^= byte << 8
        for _ in range(8):
            remainder = remainder << 1 ^ (_POLYNOMIAL if remainder & 0x8000 else 0)
            remainder &= 0xFFFF
    return remainder
