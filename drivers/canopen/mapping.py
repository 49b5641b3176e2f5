"""Process data objects: what is mapped where, as plain data.

References
----------
CiA 301, sections 7.2.2 (PDO) and 7.4.7 (data types).
"""

from collections.abc import Iterable
from typing import Final, Literal, NamedTuple

DataTypeName = Literal["i8", "u8", "i16", "u16", "i32", "u32", "f32"]

STRUCT_CODES: Final[dict[str, str]] = {
    "i8": "b",
    "u8": "B",
    "i16": "h",
    "u16": "H",
    "i32": "i",
    "u32": "I",
    "f32": "f",
}
SIZES: Final[dict[str, int]] = {
    "i8": 1,
    "u8": 1,
    "i16": 2,
    "u16": 2,
    "i32": 4,
    "u32": 4,
    "f32": 4,
}
RANGES: Final[dict[str, tuple[int, int]]] = {
    "i8": (-0x80, 0x7F),
    "u8": (0, 0xFF),
    "i16": (-0x8000, 0x7FFF),
    "u16": (0, 0xFFFF),
    "i32": (-0x8000_0000, 0x7FFF_FFFF),
    "u32": (0, 0xFFFF_FFFF),
}
"""What the integer types can hold; f32 is not among them."""

MAX_PDO_BYTES: Final = 8
MAX_PDOS: Final = 4
"""PDOs in either direction that have an identifier in the pre-defined connection set."""


class Entry(NamedTuple):
    """One mapped object."""

    object: int
    sub: int
    type: str

    @property
    def code(self) -> int:
        """The entry as a device's mapping object holds it."""
        return self.object << 16 | self.sub << 8 | 8 * SIZES[self.type]

    def __str__(self) -> str:
        return f"0x{self.object:04X}:{self.sub:02X}"


Layout = tuple[Entry, ...]
"""The objects of one PDO, in order."""


class MappedObjects(NamedTuple):
    """The objects that a device can exchange in PDOs, as its EDS says.

    Attributes
    ----------
    is_fixed : bool
        These, in this order, and no others: its mapping cannot be written.
    receive, transmit : tuple of Entry
        What it takes and sends.
    """

    is_fixed: bool
    receive: Layout
    transmit: Layout


def pack(entries: Iterable[Entry], first: int = 1) -> tuple[Layout, ...]:
    """Lay objects into as few PDOs as their order permits.

    Parameters
    ----------
    entries : iterable of Entry
        In the order in which they shall be sent.
    first : int
        The first PDO to use, 1 … 4.

    Returns
    -------
    tuple
        One layout per PDO from number `first` on.

    Raises
    ------
    ValueError
        They need more PDOs than there are.
    """
    layouts: list[Layout] = []
    current: list[Entry] = []
    size = 0
    for entry in entries:
        length = SIZES[entry.type]
        if size + length > MAX_PDO_BYTES:
            layouts.append(tuple(current))
            current, size = [], 0
        current.append(entry)
        size += length
    if current:
        layouts.append(tuple(current))
    if first - 1 + len(layouts) > MAX_PDOS:
        raise ValueError(
            f"{first - 1 + len(layouts)} PDOs would be needed, a node has {MAX_PDOS}; "
            "map fewer objects."
        )
    return tuple(layouts)


def layout_size(layout: Layout) -> int:
    """Return the length of a PDO, bytes."""
    return sum(SIZES[entry.type] for entry in layout)
