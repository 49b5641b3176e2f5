"""The EDS files of the emulated nodes, written from what the nodes do.

References
----------
CiA 306-1 V1.3, sections 4.4 … 4.6.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final, NamedTuple

from eds_writer.object_names import DRIVE, ENCODER, IO_MODULE, Names, name_of

from drivers.sim.nodes import object_dictionary as types
from drivers.sim.nodes.base import EmulatedNode
from drivers.sim.nodes.cia401 import EmulatedCia401
from drivers.sim.nodes.cia402 import EmulatedCia402
from drivers.sim.nodes.cia406 import EmulatedCia406
from drivers.sim.nodes.object_dictionary import Variable

_TYPES: Final = (
    (types.BOOLEAN, 0x0001),
    (types.INTEGER8, 0x0002),
    (types.INTEGER16, 0x0003),
    (types.INTEGER32, 0x0004),
    (types.UNSIGNED8, 0x0005),
    (types.UNSIGNED16, 0x0006),
    (types.UNSIGNED32, 0x0007),
    (types.REAL32, 0x0008),
    (types.VISIBLE_STRING, 0x0009),
)
_VAR, _ARRAY, _RECORD = 0x7, 0x8, 0x9
_MANDATORY: Final = (0x1000, 0x1001, 0x1018)
_OF_THE_NODE: Final = (0x1014, 0x1200)  # their identifiers hold the node number, as PDOs' do
_SERIAL: Final = (0x1018, 4)
_DATE: Final = "11-21-2026"
_BAUD_RATES: Final = (10, 20, 50, 125, 250, 500, 800, 1000)


class Described(NamedTuple):
    """One kind of emulated node.

    Attributes
    ----------
    make : callable
        Makes one with a node number and a plant that does nothing.
    names : Names
        Of its objects.
    title : str
        What it is.
    """

    make: Callable[[int, Any], EmulatedNode]
    names: Names
    title: str


NODES: Final = {
    "cia401-analogue": Described(
        lambda node, plant: EmulatedCia401("module", node, plant, ()),
        IO_MODULE,
        "Emulated analogue and digital module after CiA 401",
    ),
    "cia406-linear": Described(
        lambda node, plant: EmulatedCia406("encoder", node, plant, 0),
        ENCODER,
        "Emulated linear encoder after CiA 406",
    ),
    "cia402-servo": Described(
        lambda node, plant: EmulatedCia402("drive", node, plant, 0, counts_per_turn=524288),
        DRIVE,
        "Emulated servo drive after CiA 402",
    ),
}
"""By the file's name."""


class _Nothing:
    """A plant that is not there: a node's objects at power-on do not depend on it."""

    def __getattr__(self, name: str) -> Callable[..., float]:
        return lambda *_: 0.0


def describe(kind: str) -> str:
    """Return the EDS file of one of `NODES`."""
    described = NODES[kind]
    objects: dict[int, dict[int, Variable]] = {}
    for variable in described.make(1, _Nothing()).dictionary:
        objects.setdefault(variable.index, {})[variable.sub] = variable
    identity = {sub: int(item.default) for sub, item in objects[0x1018].items()}
    lists: dict[str, list[int]] = {
        "MandatoryObjects": [index for index in sorted(objects) if index in _MANDATORY],
        "OptionalObjects": [index for index in sorted(objects) if index not in _MANDATORY],
        "ManufacturerObjects": [],
    }
    parts = [_head(kind, described.title, identity)]
    for name, indices in lists.items():
        listed = {str(number): f"0x{index:04X}" for number, index in enumerate(indices, 1)}
        parts.append(_section(name, {"SupportedObjects": str(len(indices)), **listed}))
        parts += [_object(index, objects[index], described.names) for index in indices]
    return "\n".join(parts)


def _head(kind: str, title: str, identity: dict[int, int]) -> str:
    rates = {f"BaudRate_{rate}": 1 for rate in _BAUD_RATES}
    return "\n".join(
        (
            _section(
                "FileInfo",
                {
                    "FileName": f"{kind}.eds",
                    "FileVersion": 1,
                    "FileRevision": 0,
                    "EDSVersion": "4.0",
                    "Description": title,
                    "CreationTime": "12:00PM",
                    "CreationDate": _DATE,
                    "CreatedBy": "rig-controller",
                    "ModificationTime": "12:00PM",
                    "ModificationDate": _DATE,
                    "ModifiedBy": "rig-controller",
                },
            ),
            _section(
                "DeviceInfo",
                {
                    "VendorName": "rig-controller",
                    "VendorNumber": f"0x{identity[1]:08X}",
                    "ProductName": title,
                    "ProductNumber": f"0x{identity[2]:08X}",
                    "RevisionNumber": f"0x{identity[3]:08X}",
                    "OrderCode": kind,
                    **rates,
                    "SimpleBootUpMaster": 0,
                    "SimpleBootUpSlave": 1,
                    "Granularity": 8,
                    "DynamicChannelsSupported": 0,
                    "GroupMessaging": 0,
                    "NrOfRXPDO": 4,
                    "NrOfTXPDO": 4,
                    "LSS_Supported": 0,
                },
            ),
            _section("DummyUsage", {f"Dummy{kind:04X}": int(kind > 1) for kind in range(1, 8)}),
            _section("Comments", {"Lines": 1, "Line1": "Written from the emulated node itself."}),
        )
    )


def _object(index: int, variables: dict[int, Variable], names: Names) -> str:
    called = name_of(index, None, names)
    if list(variables) == [0]:
        return _variable(f"{index:04X}", called, variables[0], _default(index, 0, variables[0]))
    alike = len({item.data_type for sub, item in variables.items() if sub}) == 1
    is_record = index < 0x1C00 and index not in (0x1003, 0x1016, 0x1029)
    parts = [
        _section(
            f"{index:04X}",
            {
                "ParameterName": called,
                "ObjectType": f"0x{_ARRAY if alike and not is_record else _RECORD:X}",
                "SubNumber": len(variables),
            },
        )
    ]
    for sub, variable in sorted(variables.items()):
        parts.append(
            _variable(
                f"{index:04X}sub{sub:X}",
                name_of(index, sub, names),
                variable,
                _default(index, sub, variable),
            )
        )
    return "\n".join(parts)


def _variable(section: str, name: str, variable: Variable, default: str) -> str:
    number = next(number for kind, number in _TYPES if kind == variable.data_type)
    access = variable.access
    if access == "rw" and variable.mapping:
        access = {"r": "rww", "t": "rwr"}.get(variable.mapping, "rw")
    entries: dict[str, object] = {
        "ParameterName": name,
        "ObjectType": f"0x{_VAR:X}",
        "DataType": f"0x{number:04X}",
        "AccessType": access,
        "DefaultValue": default,
        "PDOMapping": int(bool(variable.mapping)),
    }
    whole = variable.data_type
    if (variable.low, variable.high) != (whole.low, whole.high):
        entries |= {"LowLimit": int(variable.low), "HighLimit": int(variable.high)}
    return _section(section, entries)


def _default(index: int, sub: int, variable: Variable) -> str:
    value = variable.default
    if isinstance(value, bytes) or (index, sub) == _SERIAL:
        return ""  # of each device its own
    if isinstance(value, float):
        return f"{value:g}"
    per_pdo = 0x1400 <= index < 0x1C00 and not index & 0x200 and sub == 1
    if per_pdo or (index in _OF_THE_NODE and variable.data_type.size == 4):
        return f"$NODEID+0x{value - 1:X}"  # described as node 1
    bits = 8 * variable.data_type.size
    return f"0x{value & (1 << bits) - 1:0{bits // 4}X}" if value >= 0 else str(value)


def _section(name: str, entries: Mapping[Any, object]) -> str:
    lines: Iterable[str] = (f"{key}={value}" for key, value in entries.items())
    return "\n".join((f"[{name}]", *lines, ""))
