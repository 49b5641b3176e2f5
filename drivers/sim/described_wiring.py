"""Simulated forms of a CANopen device whose driver brings none: from what it describes of itself.

The settings say what is exchanged and what counts mean (`describe_nodes`), and who should answer
(`addresses`); the device's EDS, where the profile names one, says what other objects there are.
"""

from collections.abc import Iterator
from functools import partial
from typing import Final

from drivers.canopen.described import DescribedNode, Quantity
from drivers.canopen.device_settings import CanopenDeviceSettings
from drivers.canopen.eds import Eds, read_eds
from drivers.canopen.mapping import MAX_PDOS, SIZES, Entry, Layout
from drivers.sim.direct.sensor import Measured, SimulatedSensor
from drivers.sim.nodes.base import VENDOR_ID
from drivers.sim.nodes.described import Counts, EmulatedDescribed, NodeBuild, ObjectBuild
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Address, Clock, ConfigurationError, MeasuredPlant

Described = Installed[CanopenDeviceSettings, object]

_WRITABLE: Final = ("rw", "rwr", "rww", "wo")
_PDO_PARAMETERS: Final = range(0x1400, 0x1C00)


def emulate_described(of: Described) -> tuple[EmulatedDescribed, ...]:
    """Return emulated nodes that exchange what the driver's settings describe.

    Raises
    ------
    ConfigurationError
        They describe no node, and there is no EDS of one either.
    """
    addresses = {address.number: address for address in of.built.addresses(of.name, of.serial)}
    eds = None if of.description is None else read_eds(of.description)
    nodes = _nodes_of(of, addresses, eds)
    values = iter(_values(of))
    return tuple(_emulate(node, addresses.get(node.node), eds, values) for node in nodes)


def simulate_described(of: Described, clock: Clock) -> SimulatedSensor:
    """Return a device without a bus, which measures what the nodes would send.

    Raises
    ------
    ConfigurationError
        The settings describe nothing that it could measure.
    """
    nodes = of.settings.describe_nodes(of.name)
    values = iter(_values(of))
    measured = [
        Measured(f"{node.name.removeprefix(of.name)} {quantity.name}", quantity.unit, value)
        for node in nodes
        for _, quantity, value in _inputs(node, values)
    ]
    if not measured:
        raise _nothing_described(of)
    return SimulatedSensor(of.name, measured, clock)


# What is measured -------------------------------------------------------------------------


def _values(of: Described) -> Iterator[Counts]:
    """Yield what stands at each of the plant's channels that the device is wired to; then 0."""
    plant = of.plant
    if isinstance(plant, MeasuredPlant):
        for channel in of.channels:
            yield partial(plant.channel_value, channel)
    while True:
        yield float


def _inputs(
    node: DescribedNode, values: Iterator[Counts]
) -> Iterator[tuple[Entry, Quantity, Counts]]:
    """Yield what a node sends that has a unit, each with what stands there, SI."""
    for layout in node.transmit:
        for entry in layout:
            quantity = node.quantities.get(entry)
            if quantity is not None and quantity.unit:
                yield entry, quantity, next(values)


def _in_counts(quantity: Quantity, value: Counts) -> Counts:
    gain, offset = quantity.gain or 1.0, quantity.offset
    return lambda: (value() - offset) / gain


# Nodes ------------------------------------------------------------------------------------


def _nodes_of(
    of: Described, addresses: dict[int, Address], eds: Eds | None
) -> tuple[DescribedNode, ...]:
    nodes = of.built.describe_nodes(of.name)
    if nodes:
        return nodes
    if eds is None or not addresses:
        raise _nothing_described(of)
    return tuple(
        DescribedNode(
            address.name,
            number,
            _layouts(eds, 0x1600, number),
            _layouts(eds, 0x1A00, number),
            remap=False,
            quantities={},
        )
        for number, address in addresses.items()
    )


def _nothing_described(of: Described) -> ConfigurationError:
    return ConfigurationError(
        f"{of.name}: nothing says what its simulated device would be; describe its nodes "
        "(CanopenDeviceSettings.describe_nodes), or name a simulation in its driver's row "
        "(DriverParts.simulation)"
    )


def _layouts(eds: Eds, base: int, node: int) -> tuple[Layout, ...]:
    """Return the mappings that an EDS has as shipped."""
    layouts: list[Layout] = []
    for mapping in range(base, base + MAX_PDOS):
        count = eds.number_of(mapping, 0, node) or 0
        codes = [eds.number_of(mapping, sub, node) or 0 for sub in range(1, count + 1)]
        entries = [(code >> 16, code >> 8 & 0xFF) for code in codes if code]
        kinds = [eds.type_of(*entry) for entry in entries]
        layouts.append(
            tuple(
                Entry(*entry, kind)
                for entry, kind in zip(entries, kinds, strict=True)
                if kind is not None
            )
        )
    while layouts and not layouts[-1]:
        layouts.pop()
    return tuple(layouts)


def _emulate(
    node: DescribedNode, address: Address | None, eds: Eds | None, values: Iterator[Counts]
) -> EmulatedDescribed:
    number = node.node
    who = Address(node.name, number) if address is None else address

    def told(index: int, sub: int, wanted: int | None, default: int) -> int:
        if wanted is not None:
            return wanted
        return (eds.number_of(index, sub, number) if eds is not None else None) or default

    build = NodeBuild(
        told(0x1000, 0, None, who.profile or 0),
        told(0x1018, 1, who.vendor, VENDOR_ID),
        told(0x1018, 2, who.product, 0),
        told(0x1018, 4, who.serial, 0),
        tuple(_objects(node, eds, values)),
        tuple(tuple(entry.code for entry in layout) for layout in node.receive),
        tuple(tuple(entry.code for entry in layout) for layout in node.transmit),
    )
    return EmulatedDescribed(who.name, number, build)


def _objects(
    node: DescribedNode, eds: Eds | None, values: Iterator[Counts]
) -> Iterator[ObjectBuild]:
    """Yield what is exchanged, what the node says of its scales, and the rest of its EDS."""
    counts = {
        entry: _in_counts(quantity, value) for entry, quantity, value in _inputs(node, values)
    }
    sent = {entry for layout in node.transmit for entry in layout}
    received = {entry for layout in node.receive for entry in layout}
    known: set[tuple[int, int]] = set()
    for entry in dict.fromkeys((*sent, *received, *node.quantities)):
        mapping = "r" * (entry in received) + "t" * (entry in sent)
        known.add((entry.object, entry.sub))
        yield ObjectBuild(
            entry.object, entry.sub, entry.type, 0, entry not in sent, mapping, counts.get(entry)
        )
    for item in node.told:
        if eds is None and (item.object, item.sub) not in known:
            yield ObjectBuild(item.object, item.sub, "u32", 1)
    for found in () if eds is None else eds.objects():
        place = found.object, found.sub
        if found.type in SIZES and place not in known and found.object not in _PDO_PARAMETERS:
            default = eds.number_of(*place, node.node) if eds is not None else None
            mapping = "rt" if found.mappable else ""
            writable = found.access in _WRITABLE
            yield ObjectBuild(*place, found.type, default or 0, writable, mapping)


WIRING = Wiring(emulate_described, simulate_described, needs_channels=False)
