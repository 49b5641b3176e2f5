"""What a profile says of load cells on the analogue inputs of a CiA 401 module."""

from dataclasses import dataclass
from typing import Annotated, Final

from annotated_types import Interval, MinLen, Unit

from drivers.canopen.described import DescribedNode, Quantity
from drivers.canopen.mapping import RANGES, DataTypeName, Entry, Layout, pack
from drivers.canopen.node_settings import NodeSettings
from rig.hal import Address
from rig.hal.rules import Rules

PROFILE: Final = 401
"""CiA's number of the device profile."""

_Newton = Annotated[float, Unit("N")]
_LEAST_FORCE: Final = 0.1
"""Between the ends of a line, N: less is a number without its unit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadCell:
    """One cell with its amplifier: a straight line from counts to force.

    Parameters
    ----------
    sub : int
        Sub-index of its object, which is the channel's number on most modules.
    index : int
        Index of the object: 0x6401 on a CiA 401 module, or the maker's.
    type : str
        Its data type.
    raw : tuple of float
        The converter's counts at the two ends. Beyond them the cell is overloaded, or its
        wire is off.
    force : tuple of float
        The force at the two ends, N; pressed is positive.
    zero : float
        What it shows without load, N; it is taken off.
    """

    sub: Annotated[int, Interval(ge=0, le=254)]
    index: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] = 0x6401
    type: DataTypeName = "i16"
    raw: tuple[float, float] = (-32000.0, 32000.0)
    force: tuple[_Newton, _Newton]
    zero: _Newton = 0.0

    def __post_init__(self) -> None:
        with Rules() as rule:
            if not self.raw[0] < self.raw[1]:
                rule.broken(f"raw: {self.raw[0]:g} … {self.raw[1]:g} does not rise.")
            if not abs(self.force[1] - self.force[0]) >= _LEAST_FORCE:
                rule.broken(
                    f"force: {self.force[0]:g} … {self.force[1]:g} N is no line; its ends are at "
                    f"least {_LEAST_FORCE:g} N apart."
                )
            if self.type in RANGES:
                low, high = RANGES[self.type]
                if not (low <= self.raw[0] and self.raw[1] <= high):
                    rule.broken(
                        f"raw: {self.raw[0]:g} … {self.raw[1]:g} does not fit into {self.type}, "
                        f"which holds {low} … {high}."
                    )

    @property
    def entry(self) -> Entry:
        """The object, as it is mapped into a PDO."""
        return Entry(self.index, self.sub, self.type)


@dataclass(frozen=True, slots=True)
class LoadCellSettings(NodeSettings):
    """Load cells on one CiA 401 module.

    Parameters
    ----------
    node : int
        Its number on the bus.
    cells : dict of str to LoadCell
        By name, in the order in which they are sent.
    overload_after : int
        Samples in a row at the end of a cell's range that are a fault: a landing's peak is none.
    frozen_timeout : float, optional
        If a cell does not change in a single count for so long, that is a fault, s; the noise
        of its amplifier moves it. None: it is not looked at.
    """

    scaling = ("cells",)

    node: Annotated[int, Interval(ge=1, le=127)]
    cells: Annotated[dict[str, LoadCell], MinLen(1)]
    overload_after: Annotated[int, Interval(ge=1, le=1000)] = 10
    frozen_timeout: Annotated[float, Unit("s"), Interval(ge=1e-2, le=60.0)] | None = 0.1

    def __post_init__(self) -> None:
        with Rules() as rule:
            rule.of(NodeSettings.__post_init__, self)
            rule.of(pack, [cell.entry for cell in self.cells.values()])
            entries = [(cell.index, cell.sub) for cell in self.cells.values()]
            if len(set(entries)) < len(entries):
                rule.broken("cells: two of them are on one object.")

    @property
    def layouts(self) -> tuple[Layout, ...]:
        """What the module sends each cycle, PDO by PDO."""
        return pack([cell.entry for cell in self.cells.values()])

    def channel_names(self) -> tuple[str, ...]:
        """Return the cells' names, which are the plant's channels."""
        return tuple(self.cells)

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return the module's node."""
        return (Address(device, self.node, PROFILE, self.vendor, self.product, serial),)

    def describe_nodes(self, name: str) -> tuple[DescribedNode, ...]:
        """Return what the module exchanges and what its counts mean."""
        quantities = {}
        for cell_name, cell in self.cells.items():
            gain = (cell.force[1] - cell.force[0]) / (cell.raw[1] - cell.raw[0])
            offset = cell.force[0] - gain * cell.raw[0] - cell.zero
            quantities[cell.entry] = Quantity(f"{cell_name} force", "N", gain, offset)
        origins = {cell.entry: ("cells", cell_name) for cell_name, cell in self.cells.items()}
        return (
            DescribedNode(
                name,
                self.node,
                (),
                self.layouts,
                self.remap,
                quantities,
                origins,
                contents=("", "forces"),
            ),
        )
