"""The emulated servos of one device, with the faults that can be injected by name."""

from collections.abc import Callable, Sequence

from drivers.sim.dynamixel.chain import Station
from drivers.sim.dynamixel.servo import EmulatedServo

_HARDWARE_BITS = {
    "undervoltage": 0,
    "encoder_broken": 3,
    "shock": 4,
    "overloaded": 5,
}
_TWIN_OFFSET = 0.5  # rad: a second servo with the same id stands somewhere else


class EmulatedDynamixel:
    """The servos of one device on a chain.

    Every fault takes the number of the joint in the device's order (default 0):

    ``silent``
        It hears and says nothing, as with a broken wire behind the one before it.
    ``overheated``, ``warm``
        85 °C, at which it drops its torque; 75 °C, which it bears.
    ``undervoltage``, ``encoder_broken``, ``shock``, ``overloaded``
        A hardware error of that name; the last two make it drop its torque.
    ``corrupted``, ``truncated``, ``doubled``
        So do its answers come; in a fast reply, where each has its place, none can double.
    ``same_id``
        A second servo with its id answers at the same time.
    ``rebooted``
        It starts afresh: no torque, no watchdog, no settings that are not in EEPROM.
    ``repair``
        Ends what lasts, with every servo.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    stations : sequence of Station
        Its servos, in the device's order.
    make_twin : callable
        Makes another servo like number k.
    """

    def __init__(
        self,
        name: str,
        stations: Sequence[Station],
        make_twin: Callable[[int, float], EmulatedServo],
    ) -> None:
        self.name = name
        self.stations = tuple(stations)
        self._make_twin = make_twin
        self._faults: dict[str, Callable[[int], None]] = {
            "silent": self._disconnect,
            "overheated": lambda k: self._servo(k).heat(85),
            "warm": lambda k: self._servo(k).heat(75),
            "corrupted": lambda k: self._distort(k, corrupt),
            "truncated": lambda k: self._distort(k, truncate),
            "doubled": lambda k: self._distort(k, double),
            "same_id": self._add_twin,
            "rebooted": lambda k: self._servo(k).reboot(),
        }
        for fault, bit in _HARDWARE_BITS.items():
            self._faults[fault] = lambda k, bit=bit: self._servo(k).fail(bit)  # type: ignore[misc]

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` understands."""
        return (*self._faults, "repair")

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now.

        Raises
        ------
        ValueError
            The fault is not known here, or there is no such joint.
        """
        if fault == "repair":
            self._repair()
            return
        action = self._faults.get(fault)
        if action is None:
            known = ", ".join(self.known_faults)
            raise ValueError(f"{self.name}: no fault {fault!r}; known are {known}")
        number = 0.0 if value is None else value
        if number not in range(len(self.stations)):
            raise ValueError(
                f"{self.name}: no joint number {number:g}; there are {len(self.stations)}, from 0"
            )
        action(int(number))

    def _servo(self, k: int) -> EmulatedServo:
        return self.stations[k].servo

    def _disconnect(self, k: int) -> None:
        self.stations[k].connected = False

    def _distort(self, k: int, how: Callable[[bytes], bytes]) -> None:
        self.stations[k].distort = how

    def _add_twin(self, k: int) -> None:
        self.stations[k].twin = self._make_twin(k, _TWIN_OFFSET)

    def _repair(self) -> None:
        for station in self.stations:
            station.connected = True
            station.distort = None
            station.twin = None


def corrupt(answer: bytes) -> bytes:
    """Flip a bit in the middle."""
    middle = len(answer) // 2
    return answer[:middle] + bytes((answer[middle] ^ 0x10,)) + answer[middle + 1 :]


def truncate(answer: bytes) -> bytes:
    """Stop half-way."""
    return answer[: len(answer) // 2]


def double(answer: bytes) -> bytes:
    """Say it twice."""
    return answer * 2
