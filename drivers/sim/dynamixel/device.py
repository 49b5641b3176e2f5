"""The emulated servos of one device, with the faults that can be injected by name."""

from collections.abc import Callable, Mapping
from functools import partial
from math import inf

from drivers.sim.axis_faults import AxisFaults
from drivers.sim.dynamixel.chain import Station
from drivers.sim.dynamixel.servo import EmulatedServo
from drivers.sim.servo_encoder import ServoEncoder

_HARDWARE_BITS = {
    "undervoltage": 0,
    "encoder_broken": 3,
    "shock": 4,
    "overloaded": 5,
}


class StationFaults:
    """The faults of one servo.

    ``silent`` (value: s, default for ever)
        It hears and says nothing, as with a broken wire.
    ``corrupted``, ``truncated``, ``doubled`` (value: s, default for ever)
        So do its answers come; in a fast reply, where each has its place, none can double.
    ``deaf`` (value: s, default for ever)
        What is written to several servos at once, as setpoints are, passes it by.
    ``same_id``
        A second servo with its id answers at the same time.
    ``overheated``, ``warm``
        85 °C, at which it drops its torque; 75 °C, which it bears.
    ``undervoltage``, ``encoder_broken``, ``shock``, ``overloaded``
        A hardware error of that name; the last two make it drop its torque.
    ``encoder_jump``, ``encoder_frozen``, ``encoder_mirrored``, ``encoder_drift``, ``encoder_scale``
        The encoder of its position loop lies, see `ServoEncoder`.
    ``rebooted``
        It starts afresh: no torque, no watchdog, no settings that are not in EEPROM.
    ``repair``
        Ends what lasts; a hardware error ends with a reboot only.

    Parameters
    ----------
    name : str
        Of device and joint.
    station : Station
        The servo on its line.
    make_twin : callable
        Makes another servo like it.
    """

    def __init__(self, name: str, station: Station, make_twin: Callable[[], EmulatedServo]) -> None:
        self.name = name
        self._station = station
        self._make_twin = make_twin

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` understands."""
        return (
            *("silent", "corrupted", "truncated", "doubled", "deaf", "same_id"),
            *("overheated", "warm"),
            *_HARDWARE_BITS,
            *ServoEncoder.lies,
            *("rebooted", "repair"),
        )

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now.

        Raises
        ------
        ValueError
            The fault is not known here, or the value does not fit it.
        """
        station = self._station
        servo = station.servo
        match fault:
            case "silent":
                station.silence(self._duration(fault, value))
            case "corrupted" | "truncated" | "doubled":
                station.distort(_DISTORTIONS[fault], self._duration(fault, value))
            case "deaf":
                station.deafen(self._duration(fault, value))
            case "same_id":
                station.twin = self._make_twin()
            case "overheated":
                servo.heat(85)
            case "warm":
                servo.heat(75)
            case "rebooted":
                servo.reboot()
            case "repair":
                station.repair()
                servo.encoder.repair()
            case _ if fault in ServoEncoder.lies:
                servo.lie(fault, value)
            case _ if fault in _HARDWARE_BITS:
                servo.fail(_HARDWARE_BITS[fault])
            case _:
                known = ", ".join(self.known_faults)
                raise ValueError(f"{self.name}: no fault {fault!r}; known are {known}")

    def _duration(self, fault: str, value: float | None) -> float:
        if value is None:
            return inf
        if not value > 0.0:
            raise ValueError(f"{self.name}: {fault} lasts longer than {value:g} s")
        return value


class EmulatedDynamixel(AxisFaults):
    """The servos of one device on a chain; a target of faults, see `StationFaults`.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    stations : mapping of str to Station
        Its servos by joint, in the device's order.
    make_twin : callable
        Makes another servo like that of a joint.
    """

    def __init__(
        self,
        name: str,
        stations: Mapping[str, Station],
        make_twin: Callable[[str], EmulatedServo],
    ) -> None:
        super().__init__(
            name,
            {
                joint: StationFaults(f"{name}.{joint}", station, partial(make_twin, joint))
                for joint, station in stations.items()
            },
        )
        self.stations = tuple(stations.values())


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


_DISTORTIONS = {"corrupted": corrupt, "truncated": truncate, "doubled": double}
