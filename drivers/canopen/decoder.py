"""CANopen frames in words: whose they are, what is in them, in SI.

References
----------
CiA 301 V4.2, sections 7.2 (services) and 7.3.3 (pre-defined connection set).
"""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Final, Protocol

from drivers.can.frame import STANDARD_MASK, decode_error_frame
from drivers.canopen.described import DescribedNode, Quantity
from drivers.canopen.device_settings import nodes_of
from drivers.canopen.eds import read_eds
from drivers.canopen.emergency import Emergency
from drivers.canopen.heartbeat import describe_state
from drivers.canopen.inputs import layout_struct
from drivers.canopen.mapping import SIZES, STRUCT_CODES, Entry, Layout, layout_size
from drivers.canopen.sdo_frame import SdoFrame, decode_sdo
from drivers.canopen.settings import CanBusSettings
from rig.hal import DriverSettings
from rig.hal.frames import UNKNOWN, Decoded, Value

_COMMANDS: Final = {
    0x01: "start",
    0x02: "stop",
    0x80: "enter PRE-OPERATIONAL",
    0x81: "reset node",
    0x82: "reset communication",
}
_PREDEFINED: Final = {
    0x080: "EMCY",
    0x180: "TPDO1",
    0x200: "RPDO1",
    0x280: "TPDO2",
    0x300: "RPDO2",
    0x380: "TPDO3",
    0x400: "RPDO3",
    0x480: "TPDO4",
    0x500: "RPDO4",
    0x580: "SDO",
    0x600: "SDO",
    0x700: "heartbeat",
}
_NAMES: Final = {
    0x1000: "device type",
    0x1001: "error register",
    0x1008: "device name",
    0x1016: "consumer heartbeat time",
    0x1017: "producer heartbeat time",
    0x1018: "identity",
    0x1029: "error behaviour",
}
_ENTRY_TEXT: Final = "0x{:04X}:{:02X}"


class ObjectNames(Protocol):
    """Names and types of a device's objects, as its EDS has them."""

    def name_of(self, index: int, sub: int) -> str | None:
        """Return what the maker calls an object."""

    def type_of(self, index: int, sub: int) -> str | None:
        """Return its data type, in the words of `drivers.canopen.mapping`."""

    def number_of(self, index: int, sub: int, node: int) -> int | None:
        """Return its default, if that is a number."""


def make_decoder(
    bus: CanBusSettings, devices: Iterable[tuple[str, DriverSettings, Path | None]]
) -> "CanopenDecoder":
    """Make the decoder of a bus.

    Parameters
    ----------
    bus : CanBusSettings
        Of the bus.
    devices : iterable of (str, DriverSettings, Path or None)
        Name, settings and EDS of each device on it. What a driver does not describe shows as
        frames of nodes without a name.

    Raises
    ------
    EdsError
        An EDS cannot be read.
    """
    nodes: list[DescribedNode] = []
    names: dict[int, ObjectNames] = {}
    for name, settings, path in devices:
        described = nodes_of(name, settings)
        nodes += described
        if path is not None and described:
            eds = read_eds(path)
            names |= {node.node: eds for node in described}
    return CanopenDecoder(nodes, bus.master_id, names)


class CanopenDecoder:
    """Decodes the frames of one bus.

    It keeps what the nodes said of their scales in earlier frames, so frames are to be given in
    their order; until then the scales are those of the profile, else of the EDS.

    Parameters
    ----------
    nodes : iterable of DescribedNode
        Every node that the profile knows.
    master : int
        The node number of the master's heartbeat.
    names : mapping, optional
        By node number: an EDS.
    """

    def __init__(
        self,
        nodes: Iterable[DescribedNode],
        master: int,
        names: Mapping[int, ObjectNames] | None = None,
    ) -> None:
        self._nodes = {node.node: node for node in nodes}
        self._master = master
        self._names = names or {}
        self._gains: dict[tuple[int, Entry], float] = {}
        self._pdos: dict[int, Callable[[bytes], Decoded]] = {}
        for node in self._nodes.values():
            eds = self._names.get(node.node)
            if eds is not None:
                for told in node.told:
                    counts = eds.number_of(told.object, told.sub, node.node)
                    self._learn(node.node, told.object, told.sub, counts or 0)
            for base, layouts, kind in (
                (0x200, node.receive, "RPDO"),
                (0x180, node.transmit, "TPDO"),
            ):
                for number, layout in enumerate(layouts):
                    can_id = base + 0x100 * number + node.node
                    self._pdos[can_id] = self._pdo(node, f"{kind}{number + 1}", layout)

    def decode(self, can_id: int, data: bytes) -> Decoded:
        """Return what a frame says; see `rig.hal.frames.Decoder`."""
        error = decode_error_frame(can_id, data)
        if error is not None:
            return error
        if can_id > STANDARD_MASK:
            return UNKNOWN
        pdo = self._pdos.get(can_id)
        if pdo is not None:
            return pdo(data)
        if can_id == 0x000 and len(data) == 2:
            return self._command(*data)
        if can_id == 0x080:
            return Decoded("", "SYNC")
        number = can_id & 0x7F
        service = _PREDEFINED.get(can_id - number)
        if service is None or not number:
            return UNKNOWN
        device = self._device(number)
        known = number in self._nodes or (number == self._master and service == "heartbeat")
        text = ""
        values: tuple[Value, ...] = ()
        if service == "heartbeat" and len(data) == 1:
            text = describe_state(data[0] & 0x7F)
        elif service == "EMCY" and len(data) == 8:
            text = str(Emergency(int.from_bytes(data[:2], "little"), data[2], bytes(data[3:])))
        elif service == "SDO" and len(data) == 8:
            values, text = self._sdo(number, decode_sdo(data, from_server=can_id < 0x600))
        elif service in ("heartbeat", "EMCY", "SDO"):
            text = f"wrong length, {len(data)} bytes"
        else:
            known = False  # a PDO that the profile does not use
        return Decoded(device, service, values, text, known)

    # Services -------------------------------------------------------------------------

    def _device(self, number: int) -> str:
        if number == self._master:
            return "master"
        node = self._nodes.get(number)
        return node.name if node is not None else f"node 0x{number:02X}"

    def _command(self, command: int, number: int) -> Decoded:
        device = self._device(number) if number else "all nodes"
        text = _COMMANDS.get(command, f"unknown command 0x{command:02X}")
        return Decoded(device, "NMT", text=text, known=command in _COMMANDS)

    def _pdo(self, node: DescribedNode, service: str, layout: Layout) -> Callable[[bytes], Decoded]:
        size, unpack = layout_size(layout), layout_struct(layout).unpack_from

        def decode(data: bytes) -> Decoded:
            if len(data) < size:
                text = f"wrong length, {len(data)} bytes where {size} are mapped"
                return Decoded(node.name, service, text=text)
            values = [
                self._value(node, entry, raw)
                for entry, raw in zip(layout, unpack(data), strict=True)
            ]
            extra = f"and {len(data) - size} bytes more" if len(data) > size else ""
            return Decoded(node.name, service, tuple(values), extra)

        return decode

    def _value(self, node: DescribedNode, entry: Entry, raw: float) -> Value:
        quantity = node.quantities.get(entry) or Quantity(
            self._name(node.node, entry.object, entry.sub) or str(entry)
        )
        if quantity.words is not None:
            return Value(quantity.name, quantity.words(int(raw)), "", str(entry))
        gain = quantity.gain
        if gain is None:
            gain = self._gains.get((node.node, entry))
            if gain is None:  # as long as the device has not said it
                return Value(quantity.name, raw, "", str(entry))
        if not quantity.unit:
            return Value(quantity.name, raw, "", str(entry))
        return Value(quantity.name, gain * raw + quantity.offset, quantity.unit, str(entry))

    def _sdo(self, number: int, frame: SdoFrame) -> tuple[tuple[Value, ...], str]:
        if frame.object is None:
            return (), frame.text
        name = self._name(number, frame.object, frame.sub)
        thing = _ENTRY_TEXT.format(frame.object, frame.sub)
        if frame.data is None:
            return (), f"{frame.text} {thing} {name}".rstrip()
        value = self._sdo_value(number, frame, name, thing)
        return (value,), f"{frame.text} {thing}"

    def _sdo_value(self, number: int, frame: SdoFrame, name: str, thing: str) -> Value:
        assert frame.object is not None and frame.data is not None
        data = frame.data
        self._learn(number, frame.object, frame.sub, int.from_bytes(data, "little"))
        node = self._nodes.get(number)
        for entry in () if node is None else node.quantities:
            if (entry.object, entry.sub) == (frame.object, frame.sub):
                assert node is not None
                return self._value(node, entry, _number(data, entry.type))
        eds = self._names.get(number)
        kind = None if eds is None else eds.type_of(frame.object, frame.sub)
        if kind is not None and SIZES[kind] == len(data):
            return Value(name, _number(data, kind), "", thing)
        return Value(name, f"0x{int.from_bytes(data, 'little'):0{2 * len(data)}X}", "", thing)

    def _learn(self, number: int, index: int, sub: int, counts: int) -> None:
        """Keep a scale that a node says of itself."""
        node = self._nodes.get(number)
        for told in () if node is None else node.told:
            if (told.object, told.sub) == (index, sub) and counts:
                self._gains[number, told.entry] = told.factor * counts

    def _name(self, number: int, index: int, sub: int) -> str:
        eds = self._names.get(number)
        name = None if eds is None else eds.name_of(index, sub)
        if name is not None:
            return name
        for base, kind in ((0x1400, "RPDO"), (0x1800, "TPDO")):
            if base <= index < base + 0x200:
                return f"{kind}{index - base + 1} communication"
            if base + 0x200 <= index < base + 0x400:
                return f"{kind}{index - base - 0x1FF} mapping"
        return _NAMES.get(index, "")


def _number(data: bytes, kind: str) -> float | int:
    import struct

    value: float | int = struct.unpack(
        "<" + STRUCT_CODES[kind], data[: SIZES[kind]].ljust(SIZES[kind], b"\0")
    )[0]
    return value
