"""Compare what a driver wants to exchange with a node, with what the node's EDS lets it."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Final, NamedTuple

from drivers.canopen.described import DescribedNode
from drivers.canopen.eds import EdsObject, read_eds
from drivers.canopen.mapping import MAX_PDOS, SIZES, Entry, Layout, MappedObjects
from rig.hal import DeviceFile, DriverSettings
from rig.hal.driver import FileIdentity, Keys, Scalar

Typed = Callable[[Mapping[str, object]], Mapping[tuple[str, ...], tuple[int, int]]]
Mapped = Callable[[Mapping[str, object], MappedObjects], Mapping[Keys, Scalar]]
Nodes = Callable[[str, DriverSettings], tuple[DescribedNode, ...]]

_CAN_BE_SENT: Final = ("ro", "rw", "rwr", "const")
_CAN_BE_RECEIVED: Final = ("wo", "rw", "rww")
_SETTABLE: Final = ("wo", "rw", "rww", "rwr")
_MOST_ENTRIES: Final = 64  # CiA 301: of one bit each
_MAPPING_OFFSET: Final = 0x200
_NOT_VALID: Final = 0x8000_0000
_IDENTIFIER: Final = 0x7FF
_ON_EVERY_SYNC: Final = 1


class Shortfall(NamedTuple):
    """Something that a device cannot do.

    Attributes
    ----------
    keys : tuple
        Which setting asks for it.
    message : str
        What it cannot do; with the line of the EDS.
    """

    keys: Keys
    message: str


class EdsFile(DeviceFile):
    """A device's own EDS beside its settings.

    Parameters
    ----------
    path : Path
        The file.
    typed : callable
        ``typed(plain)`` returns, from the settings as they were written, index and sub-index of
        every object whose type is a setting, by the keys of that setting.
    nodes : callable
        ``nodes(device, settings)`` returns what the settings want of each node.
    mapped : callable
        ``mapped(plain, objects)`` returns the settings by which objects are exchanged.

    Raises
    ------
    EdsError
        The file cannot be read or understood.
    """

    def __init__(self, path: Path, typed: Typed, nodes: Nodes, mapped: Mapped) -> None:
        self.eds = read_eds(path)
        self._typed = typed
        self._nodes = nodes
        self._mapped = mapped

    def identity(self) -> FileIdentity:
        """See `DeviceFile.identity`; a number of 0 says nothing."""
        vendor, product = (
            self.eds.device_number(key, 0) or None for key in ("VendorNumber", "ProductNumber")
        )
        kind = self.eds.number_of(0x1000, 0, 0)
        return FileIdentity(vendor, product, None if kind is None else kind & 0xFFFF)

    def mapped(self, plain: Mapping[str, object]) -> Mapping[Keys, Scalar]:
        """See `DeviceFile.mapped`."""
        fixed = self._is_fixed(0x1600) is not False and self._is_fixed(0x1A00) is not False
        if fixed:
            receive, transmit = (
                tuple(entry for number in range(MAX_PDOS) for entry in self._entries(base + number))
                for base in (0x1600, 0x1A00)
            )
        else:
            can = [found for found in self.eds.objects() if found.mappable and found.type in SIZES]
            receive, transmit = (
                tuple(
                    Entry(found.object, found.sub, found.type)
                    for found in sorted(can, key=lambda found: (found.object, found.sub))
                    if found.access in access
                )
                for access in (_CAN_BE_RECEIVED, _CAN_BE_SENT)
            )
        return self._mapped(plain, MappedObjects(fixed, receive, transmit))

    def values(self, plain: Mapping[str, object]) -> dict[tuple[str, ...], Scalar]:
        """Return the settings that the file knows, by their keys.

        Parameters
        ----------
        plain : mapping
            The settings as they were written.
        """
        known: dict[tuple[str, ...], Scalar] = {}
        for keys, (index, sub) in self._typed(plain).items():
            found = self.eds.find(index, sub)
            if found is not None and found.type in SIZES:
                known[keys] = found.type
        if self._is_fixed(0x1600) is not False and self._is_fixed(0x1A00) is not False:
            known[("remap",)] = False
        return known

    def findings(self, device: str, settings: DriverSettings) -> list[Shortfall]:
        """Return everything that the device cannot do, each once."""
        nodes = self._nodes(device, settings)
        return list(dict.fromkeys(finding for node in nodes for finding in self._compare(node)))

    # Inside ---------------------------------------------------------------------------

    def _compare(self, node: DescribedNode) -> Iterator[Shortfall]:
        for word, base, layouts, access in (
            ("RPDO", 0x1400, node.receive, _CAN_BE_RECEIVED),
            ("TPDO", 0x1800, node.transmit, _CAN_BE_SENT),
        ):
            for number, layout in enumerate(layouts):
                name = f"{word}{number + 1}"
                default = (0x200 if word == "RPDO" else 0x180) + 0x100 * number + node.node
                yield from self._check_parameters(node, name, base + number, layout, default)
                for entry in layout:
                    origin = node.origins.get(entry, ())
                    yield from self._check_entry(entry, name, access, origin)

    def _check_parameters(
        self, node: DescribedNode, name: str, index: int, layout: Layout, default: int
    ) -> Iterator[Shortfall]:
        """Check that the PDO is there, and may be set up as the driver needs it."""
        eds = self.eds
        last = node.origins.get(layout[-1], ())
        identifier, kind = eds.find(index, 1), eds.find(index, 2)
        if identifier is None or kind is None:
            yield Shortfall(last, f"{eds.path} has no {name} (0x{index:04X})")
            return
        found = eds.default_of(identifier, node.node)
        wrong = found is not None and (found & _NOT_VALID or found & _IDENTIFIER != default)
        if wrong and identifier.access not in _SETTABLE:
            text = f"{name} has the identifier 0x{found:08X}, which cannot be changed"
            yield Shortfall(last, f"{text}, and 0x{default:03X} is needed {self._at(identifier)}")
        found = eds.default_of(kind, node.node)
        if kind.access not in _SETTABLE and found not in (None, _ON_EVERY_SYNC):
            text = f"{name} has transmission type {found}, which cannot be changed"
            yield Shortfall(last, f"{text}, and {_ON_EVERY_SYNC} is needed {self._at(kind)}")
        if node.deadline and name.startswith("R"):
            yield from self._check_deadline(name, index)
        yield from self._check_mapping(node, name, index + _MAPPING_OFFSET, layout)

    def _check_deadline(self, name: str, index: int) -> Iterator[Shortfall]:
        keys, timer = ("setpoint_deadline",), self.eds.find(index, 5)
        if timer is None:
            yield Shortfall(keys, f"{self.eds.path} has no deadline of {name} (0x{index:04X}:05)")
        elif timer.access not in _SETTABLE:
            yield Shortfall(keys, f"the deadline of {name} cannot be set {self._at(timer)}")

    def _check_mapping(
        self, node: DescribedNode, name: str, mapping: int, layout: Layout
    ) -> Iterator[Shortfall]:
        last = node.origins.get(layout[-1], ())
        count = self.eds.find(mapping, 0)
        if count is None:
            yield Shortfall(last, f"{self.eds.path} has no mapping of {name} (0x{mapping:04X})")
            return
        slots = self._slots(mapping)
        if self._is_fixed(mapping):
            have, want = self._default_mapping(mapping), [entry.code for entry in layout]
            if have is not None and have != want:
                text = f"the mapping of {name} cannot be changed: it is {_codes(have)}"
                message = f"{text}, and {_codes(want)} is needed {self._at(count)}"
                yield Shortfall(last, message)
            elif node.remap:
                message = f"the mapping of {name} cannot be written {self._at(count)}"
                yield Shortfall(("remap",), message)
        elif len(layout) > len(slots):
            extra = node.origins.get(layout[len(slots)], ())
            what = f"{name} can map {len(slots)} objects at most, not {len(layout)}"
            yield Shortfall(extra, f"{what} {self._at(count)}")

    def _check_entry(
        self, entry: Entry, name: str, access: tuple[str, ...], origin: Keys
    ) -> Iterator[Shortfall]:
        found = self.eds.find(entry.object, entry.sub)
        if found is None:
            yield Shortfall(origin, f"{self.eds.path} has no object {entry}, which {name} needs")
            return
        where = self._at(found)
        if not found.mappable:
            yield Shortfall(origin, f"object {entry} cannot be mapped into a PDO {where}")
        elif found.access not in access:
            done = f"{'sent' if access is _CAN_BE_SENT else 'received'} in {name}"
            yield Shortfall(
                origin, f"object {entry} is {found.access} and cannot be {done} {where}"
            )
        if found.type != entry.type:
            message = f"object {entry} is {found.type}, not {entry.type} {where}"
            yield Shortfall((*origin, "type"), message)
        bits, step = 8 * SIZES[entry.type], self.eds.device_number("Granularity", 8)
        if step and bits % step:
            text = f"object {entry} has {bits} bits, but the device maps in steps of {step}"
            yield Shortfall(origin, f"{text} {where}")

    def _is_fixed(self, mapping: int) -> bool | None:
        """Return whether a mapping cannot be written; None if there is none."""
        count = self.eds.find(mapping, 0)
        if count is None:
            return None
        first = self.eds.find(mapping, 1)
        writable = count.access in _SETTABLE and first is not None and first.access in _SETTABLE
        return not writable or self.eds.device_number("Granularity", 8) == 0

    def _slots(self, mapping: int) -> list[EdsObject]:
        slots = []
        for sub in range(1, _MOST_ENTRIES + 1):
            found = self.eds.find(mapping, sub)
            if found is None:
                break
            slots.append(found)
        return slots

    def _default_mapping(self, mapping: int) -> list[int] | None:
        """Return the entries that are mapped as shipped; None if the file does not say."""
        defaults = [self.eds.default_of(slot, 0) for slot in self._slots(mapping)]
        count = self.eds.find(mapping, 0)
        number = None if count is None else self.eds.default_of(count, 0)
        known = [code for code in defaults if code is not None]
        if len(known) < len(defaults) and number is None:
            return None
        used = known if number is None else known[:number]
        return [code for code in used if code]

    def _entries(self, mapping: int) -> Iterator[Entry]:
        """Yield the objects that a PDO carries as shipped, as far as their types are known."""
        for code in self._default_mapping(mapping) or ():
            index, sub = code >> 16, code >> 8 & 0xFF
            kind = self.eds.type_of(index, sub)
            if kind is not None:
                yield Entry(index, sub, kind)

    def _at(self, found: EdsObject) -> str:
        return f"({self.eds.path}:{found.line})"


def _codes(codes: list[int]) -> str:
    return " ".join(f"{code:08X}" for code in codes) or "nothing"
