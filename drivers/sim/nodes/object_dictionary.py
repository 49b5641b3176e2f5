"""The object dictionary of an emulated node: typed, access-checked, resettable.

References
----------
CiA 301 V4.2, sections 7.2.4.3.17 (SDO abort codes) and 7.4 (object dictionary).
"""

from collections.abc import Callable, Iterator
from dataclasses import KW_ONLY, dataclass, field
from enum import IntEnum
from math import inf
from struct import Struct
from typing import NamedTuple

Value = int | float | bytes


class Abort(IntEnum):
    """SDO abort codes that these nodes use."""

    TOGGLE = 0x05030000
    TIMEOUT = 0x05040000
    COMMAND = 0x05040001
    UNSUPPORTED_ACCESS = 0x06010000
    WRITE_ONLY = 0x06010001
    READ_ONLY = 0x06010002
    NO_OBJECT = 0x06020000
    NOT_MAPPABLE = 0x06040041
    MAPPING_TOO_LONG = 0x06040042
    INCOMPATIBLE_PARAMETER = 0x06040043
    LENGTH = 0x06070010
    NO_SUB_INDEX = 0x06090011
    RANGE = 0x06090030
    GENERAL = 0x08000000
    DEVICE_STATE = 0x08000022
    NO_DATA = 0x08000024


class SdoAbortError(Exception):
    """An access to the object dictionary that the device refuses.

    Parameters
    ----------
    code : int
        The abort code that the client gets.
    """

    def __init__(self, code: int) -> None:
        self.code = int(code)
        super().__init__(f"SDO abort 0x{self.code:08X}")


class DataType(NamedTuple):
    """A type: its bytes, little-endian, and its range."""

    code: str
    size: int
    low: float
    high: float


def _integer(code: str, size: int, *, signed: bool) -> DataType:
    bits = 8 * size
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
    return DataType(code, size, low, high)


BOOLEAN = DataType("B", 1, 0, 1)
INTEGER8 = _integer("b", 1, signed=True)
INTEGER16 = _integer("h", 2, signed=True)
INTEGER32 = _integer("i", 4, signed=True)
UNSIGNED8 = _integer("B", 1, signed=False)
UNSIGNED16 = _integer("H", 2, signed=False)
UNSIGNED32 = _integer("I", 4, signed=False)
REAL32 = DataType("f", 4, float("-inf"), float("inf"))
VISIBLE_STRING = DataType("", 0, 0, 0)

BY_NAME = {
    "i8": INTEGER8,
    "i16": INTEGER16,
    "i32": INTEGER32,
    "u8": UNSIGNED8,
    "u16": UNSIGNED16,
    "u32": UNSIGNED32,
    "f32": REAL32,
}
"""Types by their names in profiles."""

_STRUCTS = {code: Struct("<" + code) for code in "bBhHiIf"}


@dataclass(slots=True, eq=False)
class Variable:
    """One value of the object dictionary.

    Parameters
    ----------
    data_type : DataType
        Its type on the wire.
    default : int, float or bytes
        Its value after power-on.
    access : str
        ``"ro"``, ``"rw"`` or ``"const"``.
    low, high : float, optional
        Permitted values where they are narrower than the type.
    mapping : str
        ``"r"`` if an RPDO may carry it, ``"t"`` if a TPDO may, ``"rt"`` or ``""``.
    check : callable, optional
        Called with a new value before it is stored; raises `SdoAbortError` to refuse it.
    changed : callable, optional
        Called after an SDO has stored a value.
    refresh : callable, optional
        Called before an SDO reads, to bring `value` up to date.
    """

    data_type: DataType
    default: Value = 0
    access: str = "rw"
    _: KW_ONLY
    low: float = -inf
    high: float = inf
    mapping: str = ""
    check: Callable[[int], None] | None = None
    changed: Callable[[], None] | None = None
    refresh: Callable[[], None] | None = None
    value: Value = field(init=False)
    index: int = field(init=False, default=0)
    sub: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self.value = self.default
        self.low = max(self.low, self.data_type.low)
        self.high = min(self.high, self.data_type.high)

    @property
    def integer(self) -> int:
        """The value of an integer object."""
        return int(self.value)

    def encode(self) -> bytes:
        """Return the value's bytes."""
        if isinstance(self.value, bytes):
            return self.value
        return _STRUCTS[self.data_type.code].pack(self.value)

    def decode(self, data: bytes) -> Value:
        """Return the value that bytes of the right length stand for."""
        if self.data_type.size == 0:
            return data
        value: Value = _STRUCTS[self.data_type.code].unpack(data)[0]
        return value


class ObjectDictionary:
    """All variables of a node, by index and sub-index."""

    def __init__(self) -> None:
        self._variables: dict[tuple[int, int], Variable] = {}
        self._indices: set[int] = set()

    def add(self, index: int, sub: int, variable: Variable) -> Variable:
        """Enter a variable and return it.

        Raises
        ------
        ValueError
            Something is there already.
        """
        if (index, sub) in self._variables:
            raise ValueError(f"object 0x{index:04X}:{sub:02X} is defined twice")
        variable.index, variable.sub = index, sub
        self._variables[index, sub] = variable
        self._indices.add(index)
        return variable

    def add_array(self, index: int, variables: list[Variable]) -> list[Variable]:
        """Enter an array or record: sub-index 0 counts, then one sub-index for each."""
        self.add(index, 0, Variable(UNSIGNED8, len(variables), "const"))
        for sub, variable in enumerate(variables, start=1):
            self.add(index, sub, variable)
        return variables

    def find(self, index: int, sub: int) -> Variable:
        """Return a variable.

        Raises
        ------
        SdoAbortError
            There is none: no such object, or no such sub-index of it.
        """
        variable = self._variables.get((index, sub))
        if variable is None:
            raise SdoAbortError(Abort.NO_SUB_INDEX if index in self._indices else Abort.NO_OBJECT)
        return variable

    def __iter__(self) -> Iterator[Variable]:
        return iter(self._variables.values())

    def read(self, index: int, sub: int) -> bytes:
        """Return the bytes of an object as an SDO upload does, or raise `SdoAbortError`."""
        variable = self.find(index, sub)
        if variable.refresh is not None:
            variable.refresh()
        return variable.encode()

    def write(self, index: int, sub: int, data: bytes) -> None:
        """Store bytes as an SDO download does, or raise `SdoAbortError` and leave all as it was."""
        variable = self.find(index, sub)
        if variable.access != "rw":
            raise SdoAbortError(Abort.READ_ONLY)
        if variable.data_type.size and len(data) != variable.data_type.size:
            raise SdoAbortError(Abort.LENGTH)
        value = variable.decode(data)
        # A NaN in a REAL32 fails the comparison and is refused as it should be.
        if not isinstance(value, bytes) and not variable.low <= value <= variable.high:
            raise SdoAbortError(Abort.RANGE)
        if variable.check is not None and not isinstance(value, bytes):
            variable.check(int(value))
        variable.value = value
        if variable.changed is not None:
            variable.changed()

    def restore(self, *, communication_only: bool) -> None:
        """Set the power-on values of the communication area, or of all objects."""
        for variable in self._variables.values():
            if not communication_only or 0x1000 <= variable.index < 0x2000:
                variable.value = variable.default
