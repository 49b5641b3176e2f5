"""The emulated servos of one device, with the faults that can be injected by name."""

from collections.abc import Callable, Mapping
from functools import partial

from drivers.sim.axis_faults import AxisFaults
from drivers.sim.breakable import Breakable
from drivers.sim.dynamixel.chain import Distortion, Station
from drivers.sim.dynamixel.servo import EmulatedServo
from drivers.sim.servo_encoder import ServoEncoder

_TEMPERATURES = {"overheated": 85, "warm": 75}  # °C
_HARDWARE_BITS = {
    "undervoltage": 0,
    "encoder_broken": 3,
    "shock": 4,
    "overloaded": 5,
}


class StationFaults(Breakable):
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
        super().__init__()
        self.name = name
        self._station = station
        self._make_twin = make_twin
        self._servo = servo = station.servo
        self.add_fault("silent", self._silence)
        for fault, distortion in _DISTORTIONS.items():
            self.add_fault(fault, partial(self._distort, fault, distortion))
        self.add_fault("deaf", self._deafen)
        self.add_fault("same_id", self._double)
        for fault, celsius in _TEMPERATURES.items():
            self.add_fault(fault, partial(self._heat, celsius))
        for fault, bit in _HARDWARE_BITS.items():
            self.add_fault(fault, partial(self._fail, bit))
        for lie in ServoEncoder.lies:
            self.add_fault(lie, partial(servo.lie, lie))
        self.add_fault("rebooted", lambda _: servo.reboot())

    def repair(self) -> None:
        """End all faults that last."""
        self._station.repair()
        self._servo.encoder.repair()

    def _silence(self, duration: float | None) -> None:
        self._station.silence(self.lasting_time("silent", duration))

    def _deafen(self, duration: float | None) -> None:
        self._station.deafen(self.lasting_time("deaf", duration))

    def _distort(self, fault: str, distortion: Distortion, duration: float | None) -> None:
        self._station.distort(distortion, self.lasting_time(fault, duration))

    def _double(self, _: float | None) -> None:
        self._station.twin = self._make_twin()

    def _heat(self, celsius: int, _: float | None) -> None:
        self._servo.heat(celsius)

    def _fail(self, bit: int, _: float | None) -> None:
        self._servo.fail(bit)


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
