"""The memory of an X-series servo: what stands where, and who may write it.

References
----------
ROBOTIS e-Manual, control table of XM430-W350: addresses, sizes, initial values, ranges.
"""

from typing import NamedTuple

EEPROM_END = 64
INDIRECT_COUNT = 28
SIZE = 768
_POINTERS = range(168, 168 + 2 * INDIRECT_COUNT)


class Item(NamedTuple):
    """One entry.

    Attributes
    ----------
    address, size : int
        Where, and how many bytes.
    initial : int
        Its value after a factory reset (EEPROM) or power-on (RAM).
    low, high : int
        Its range.
    writable : bool
        Whether a host may write it.
    """

    address: int
    size: int
    initial: int = 0
    low: int = 0
    high: int = 0
    writable: bool = True

    @property
    def signed(self) -> bool:
        """Return whether it can be negative."""
        return self.low < 0


def _read_only(address: int, size: int, low: int = 0) -> Item:
    return Item(address, size, low=low, writable=False)


MODEL, FIRMWARE, ID = _read_only(0, 2), _read_only(6, 1), Item(7, 1, 1, 0, 252)
BAUD, RETURN_DELAY = Item(8, 1, 1, 0, 7), Item(9, 1, 250, 0, 254)
DRIVE_MODE, OPERATING_MODE = Item(10, 1, 0, 0, 13), Item(11, 1, 3, 0, 16)
SECONDARY_ID, PROTOCOL = Item(12, 1, 255, 0, 255), Item(13, 1, 2, 1, 2)
HOMING_OFFSET = Item(20, 4, 0, -1_044_479, 1_044_479)
MOVING_THRESHOLD = Item(24, 4, 10, 0, 1023)
TEMPERATURE_LIMIT, MAX_VOLTAGE, MIN_VOLTAGE = (
    Item(31, 1, 80, 0, 100),
    Item(32, 2, 160, 95, 160),
    Item(34, 2, 95, 95, 160),
)
PWM_LIMIT, CURRENT_LIMIT = Item(36, 2, 885, 0, 885), Item(38, 2, 1193, 0, 1193)
VELOCITY_LIMIT = Item(44, 4, 200, 0, 1023)
MAX_POSITION, MIN_POSITION = Item(48, 4, 4095, 0, 4095), Item(52, 4, 0, 0, 4095)
SHUTDOWN = Item(63, 1, 52, 0, 63)
TORQUE, LED = Item(64, 1, 0, 0, 1), Item(65, 1, 0, 0, 1)
STATUS_LEVEL = Item(68, 1, 2, 0, 2)
REGISTERED, HARDWARE_ERROR = _read_only(69, 1), _read_only(70, 1)
GAINS = tuple(
    Item(address, 2, initial, 0, 16_383)
    for address, initial in ((76, 1920), (78, 100), (80, 0), (82, 0), (84, 800), (88, 0), (90, 0))
)
WATCHDOG = Item(98, 1, 0, -1, 127)
GOAL_PWM, GOAL_CURRENT = Item(100, 2, 885, -885, 885), Item(102, 2, 1193, -1193, 1193)
GOAL_VELOCITY = Item(104, 4, 0, -1023, 1023)
PROFILE_ACCELERATION, PROFILE_VELOCITY = Item(108, 4, 0, 0, 32_767), Item(112, 4, 0, 0, 32_767)
GOAL_POSITION = Item(116, 4, 0, -1_048_575, 1_048_575)
TICK, MOVING, MOVING_STATUS = _read_only(120, 2), _read_only(122, 1), _read_only(123, 1)
PRESENT_PWM, PRESENT_CURRENT = _read_only(124, 2, -1), _read_only(126, 2, -1)
PRESENT_VELOCITY, PRESENT_POSITION = _read_only(128, 4, -1), _read_only(132, 4, -1)
VELOCITY_TRAJECTORY, POSITION_TRAJECTORY = _read_only(136, 4, -1), _read_only(140, 4, -1)
VOLTAGE, TEMPERATURE = _read_only(144, 2), _read_only(146, 1)

GOALS = (
    GOAL_PWM,
    GOAL_CURRENT,
    GOAL_VELOCITY,
    PROFILE_ACCELERATION,
    PROFILE_VELOCITY,
    GOAL_POSITION,
)
"""What nobody can write once the bus watchdog has tripped."""

ITEMS = (
    MODEL, FIRMWARE, ID, BAUD, RETURN_DELAY, DRIVE_MODE, OPERATING_MODE, SECONDARY_ID, PROTOCOL,
    HOMING_OFFSET, MOVING_THRESHOLD, TEMPERATURE_LIMIT, MAX_VOLTAGE, MIN_VOLTAGE, PWM_LIMIT,
    CURRENT_LIMIT, VELOCITY_LIMIT, MAX_POSITION, MIN_POSITION, SHUTDOWN, TORQUE, LED,
    STATUS_LEVEL, REGISTERED, HARDWARE_ERROR, *GAINS, WATCHDOG, *GOALS, TICK, MOVING,
    MOVING_STATUS, PRESENT_PWM, PRESENT_CURRENT, PRESENT_VELOCITY, PRESENT_POSITION,
    VELOCITY_TRAJECTORY, POSITION_TRAJECTORY, VOLTAGE, TEMPERATURE,
)  # fmt: skip


class ControlTable:
    """Bytes with the rules of who may change them.

    Parameters
    ----------
    indirect_data : int
        Where this model has its indirect data.
    """

    def __init__(self, indirect_data: int = 224) -> None:
        self._bytes = bytearray(SIZE)
        self._pointers = tuple(
            Item(_POINTERS[2 * k], 2, indirect_data + k, 0, SIZE - 1) for k in range(INDIRECT_COUNT)
        )
        self._items = {item.address: item for item in (*ITEMS, *self._pointers)}
        self._indirect = range(indirect_data, indirect_data + INDIRECT_COUNT)
        self._targets = [0] * INDIRECT_COUNT
        for item in self._items.values():
            self[item] = item.initial

    def power_on(self) -> None:
        """Forget what stands in RAM."""
        for item in self._items.values():
            if item.address >= EEPROM_END and item not in (VOLTAGE, TEMPERATURE):
                self[item] = item.initial

    def __getitem__(self, item: Item) -> int:
        address, size, _, low, _, _ = item
        content = self._bytes[address : address + size]
        return int.from_bytes(content, "little", signed=low < 0)

    def __setitem__(self, item: Item, value: int) -> None:
        address, size, _, low, _, _ = item
        self._bytes[address : address + size] = value.to_bytes(size, "little", signed=low < 0)
        if address in _POINTERS:
            self._targets[(address - _POINTERS.start) // 2] = value

    def item_at(self, address: int) -> Item | None:
        """Return what begins at an address."""
        return self._items.get(address)

    def is_indirect(self, address: int) -> bool:
        """Return whether an address is a byte of indirect data."""
        return address in self._indirect

    def resolve(self, address: int) -> int:
        """Return where a byte really is: indirect data stand elsewhere."""
        if address not in self._indirect:
            return address
        return self._targets[address - self._indirect.start]

    def read(self, address: int, size: int) -> bytes:
        """Return bytes, following indirect addresses."""
        if address not in self._indirect:
            return bytes(self._bytes[address : address + size])
        start = address - self._indirect.start
        memory = self._bytes
        followed = bytes([memory[target] for target in self._targets[start : start + size]])
        rest = size - len(followed)
        return followed + bytes(memory[address + len(followed) :][:rest]) if rest else followed
