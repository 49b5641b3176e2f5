"""What a profile says of joints on CiA 402 drives."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Final, Literal, Self

from annotated_types import Gt, Interval, MinLen, Unit

from drivers.canopen.described import DescribedNode, Quantity, Told
from drivers.canopen.mapping import RANGES, Entry, Layout, pack
from drivers.canopen.node_settings import NodeSettings
from drivers.canopen.settings import CanBusSettings
from drivers.cia402.contact import DIGITAL_INPUTS
from drivers.cia402.contact_settings import ContactSettings
from drivers.cia402.errors import describe_error
from drivers.cia402.states import decode_state
from drivers.servos.axis_settings import FollowingAxisSettings, bounds_of
from rig.hal import Address
from rig.hal.driver import AxisBounds, Keys
from rig.hal.rules import Rules

PROFILE: Final = 402
"""CiA's number of the device profile."""

Mode = Literal["csp", "csv"]
Feedback = Literal["velocity", "torque", "error_code", "demand"]

_TARGETS: Final[dict[str, Entry]] = {
    "csp": Entry(0x607A, 0, "i32"),
    "csv": Entry(0x60FF, 0, "i32"),
}
_FEEDBACK: Final[dict[str, Entry]] = {
    "velocity": Entry(0x606C, 0, "i32"),
    "torque": Entry(0x6077, 0, "i16"),
    "error_code": Entry(0x603F, 0, "u16"),
    "demand": Entry(0x6062, 0, "i32"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveSettings(FollowingAxisSettings):
    """One joint with its drive.

    Parameters
    ----------
    node : int
        The drive's number on the bus.
    counts_per_turn : float
        Position units for one turn of the drive's shaft; compared with what the drive says
        in 0x6092, or in 0x608F and 0x6091.
    velocity_units : float, optional
        Velocity units for one turn per second of the shaft. None: position units per second.
    acceleration_units : float, optional
        Acceleration units for one turn per second squared. None: position units.
    max_torque : float, optional
        Where the drive itself limits the joint's torque, N m. None: as the drive has it.
    serial : int, optional
        The serial number that the drive must report.
    """

    node: Annotated[int, Interval(ge=1, le=127)]
    counts_per_turn: Annotated[float, Unit("1"), Gt(0)]
    velocity_units: Annotated[float, Unit("1"), Gt(0)] | None = None
    acceleration_units: Annotated[float, Unit("1"), Gt(0)] | None = None
    max_torque: Annotated[float, Unit("N m"), Gt(0)] | None = None
    serial: Annotated[int, Interval(ge=0, le=0xFFFF_FFFF)] | None = None

    def __post_init__(self) -> None:
        # A dataclass with slots is a new class, which a bare super() would not find.
        FollowingAxisSettings.__post_init__(self)
        low, high = RANGES["i32"]
        for angle in self.limits:
            counts = (angle - self.offset) * self.counts_per_radian
            if not low <= counts <= high:
                raise ValueError(
                    f"limits: {angle:g} rad is {counts:.4g} counts, which a 32-bit position "
                    "cannot hold; change offset, gear or counts_per_turn."
                )

    def gentle(self, speed: float, window: float, effort: float) -> Self:
        """Return the settings of an axis that nobody trusts yet; see `DriverSettings.gentle`."""
        slow = FollowingAxisSettings.gentle(self, speed, window, effort)
        most = self.max_torque
        return slow if most is None else replace(slow, max_torque=effort * most)

    @property
    def counts_per_radian(self) -> float:
        """Signed position units for one radian of the joint."""
        return self.turns_per_radian * self.counts_per_turn

    @property
    def velocity_per_radian(self) -> float:
        """Signed velocity units for one radian per second of the joint."""
        return self.turns_per_radian * (self.velocity_units or self.counts_per_turn)

    @property
    def acceleration_per_radian(self) -> float:
        """Acceleration units for one radian per second squared of the joint."""
        return abs(self.turns_per_radian) * (self.acceleration_units or self.counts_per_turn)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cia402Settings(NodeSettings):
    """Joints on CiA 402 drives, one node each, in a cyclic synchronous mode.

    Parameters
    ----------
    joints : dict of str to DriveSettings
        In the order of the joints.
    mode : str
        ``csp``: the drives follow positions. ``csv``: they follow velocities, and positions
        are held by the rig's loop.
    feedback : tuple of str
        What each drive sends beside status word, position and mode, in a second PDO. Without
        ``error_code`` a fault is named from the drive's emergency message alone. With ``demand``,
        in ``csp``, setpoints that do not arrive, or come late, are found; it costs another PDO.
    position_gain : float
        In ``csv``: velocity for an error in position, 1/s, where positions are commanded
        or the velocity is zero.
    after_stop : str
        What a drive does when it has stopped quickly: ``hold`` its position under torque
        until it is connected again (a joint that gravity pulls does not fall), or
        ``release`` its torque (for joints with brakes that the drive applies itself).
    enable_time : float
        How long the drives may take to enable operation, s.
    absent : tuple of int
        Objects among those that are written at each start that these drives do not have;
        what the drive does instead must be found in its manual.
    stop_contact : ContactSettings, optional
        The emergency stop, if one of the drives reads its contact.
    """

    scaling = ("joints.*.gear", "joints.*.reversed", "joints.*.offset", "joints.*.counts_per_turn")

    joints: Annotated[dict[str, DriveSettings], MinLen(1)]
    mode: Mode = "csp"
    feedback: tuple[Feedback, ...] = ("velocity", "torque", "error_code")
    position_gain: Annotated[float, Unit("1/s"), Gt(0)] = 10.0
    after_stop: Literal["hold", "release"] = "hold"
    enable_time: Annotated[float, Unit("s"), Interval(ge=1e-3, le=60.0)] = 1.0
    absent: tuple[int, ...] = ()
    stop_contact: ContactSettings | None = None

    def __post_init__(self) -> None:
        with Rules() as rule:
            owner: dict[int, str] = {}
            for name, joint in self.joints.items():
                if joint.node in owner:
                    rule.broken(
                        f"joints {owner[joint.node]} and {name} have the same node number "
                        f"0x{joint.node:02X}."
                    )
                owner[joint.node] = name
            if "demand" in self.feedback and self.mode != "csp":
                rule.broken("feedback: demand is a position, which drives in csv are not sent.")
            if len(set(self.feedback)) != len(self.feedback):
                rule.broken("feedback: a quantity is named twice.")
            if self.stop_contact is not None and self.stop_contact.joint not in self.joints:
                rule.broken(f"stop_contact: there is no joint {self.stop_contact.joint}.")
            rule.of(NodeSettings.__post_init__, self)

    def axis_bounds(self) -> Mapping[str, AxisBounds]:
        """Return each joint's limits and greatest speed."""
        return bounds_of(self.joints)

    def gentle(self, speed: float, window: float, effort: float) -> Self:
        """Return the settings for drives that nobody trusts yet; see `DriverSettings.gentle`."""
        slow = {name: its.gentle(speed, window, effort) for name, its in self.joints.items()}
        return replace(self, joints=slow)

    def channel_names(self) -> tuple[str, ...]:
        """Return the joints' names, in order."""
        return tuple(self.joints)

    def resolution(self, channel: str) -> float:
        """Return the angle of one count of a joint, rad."""
        return 1.0 / abs(self.joints[channel].counts_per_radian)

    def holds_without_position(self) -> bool:
        """Return that a drive is switched to csv then; see `Cia402Drive.stop`."""
        return True

    def acts_after(self, bus: object) -> float | None:
        """Return after how long without the program it makes itself safe, s: its heartbeat."""
        return bus.heartbeat_timeout if isinstance(bus, CanBusSettings) else None

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return the node of each joint's drive."""
        return tuple(
            Address(
                f"{device}.{joint}",
                drive.node,
                PROFILE,
                self.vendor,
                self.product,
                serial if drive.serial is None else drive.serial,
            )
            for joint, drive in self.joints.items()
        )

    @property
    def receive_layout(self) -> Layout:
        """What each drive receives in its one PDO."""
        return (Entry(0x6040, 0, "u16"), _TARGETS[self.mode], Entry(0x6060, 0, "i8"))

    def transmit_layouts(self, joint: str) -> tuple[Layout, ...]:
        """Return what a joint's drive sends, PDO by PDO; the contact's at the end."""
        # Feedback has a PDO of its own, so that the first one is the same on every drive.
        first: Layout = (Entry(0x6041, 0, "u16"), Entry(0x6064, 0, "i32"), Entry(0x6061, 0, "i8"))
        entries = [_FEEDBACK[name] for name in self.feedback]
        if self.stop_contact is not None and self.stop_contact.joint == joint:
            entries.append(DIGITAL_INPUTS)
        return (first, *pack(entries, first=2))

    def describe_nodes(self, name: str) -> tuple[DescribedNode, ...]:
        """Return what each drive exchanges and what its counts mean."""
        origins: dict[Entry, Keys] = {
            _TARGETS[self.mode]: ("mode",),
            DIGITAL_INPUTS: ("stop_contact",),
        }
        for k, what in enumerate(self.feedback):
            origins[_FEEDBACK[what]] = ("feedback", k)
        return tuple(
            DescribedNode(
                f"{name} {joint}",
                drive.node,
                (self.receive_layout,),
                self.transmit_layouts(joint),
                self.remap,
                _quantities(drive),
                origins,
                (Told(0x6076, 0, _FEEDBACK["torque"], _torque_factor(drive)),),
                contents=("setpoint", "state"),
            )
            for joint, drive in self.joints.items()
        )


def _quantities(drive: DriveSettings) -> dict[Entry, Quantity]:
    angle, speed = 1.0 / drive.counts_per_radian, 1.0 / drive.velocity_per_radian
    return {
        Entry(0x6040, 0, "u16"): Quantity("control", words=_control_words),
        Entry(0x6041, 0, "u16"): Quantity("status", words=_status_words),
        Entry(0x6060, 0, "i8"): Quantity("mode", words=_mode_words),
        Entry(0x6061, 0, "i8"): Quantity("mode", words=_mode_words),
        Entry(0x6064, 0, "i32"): Quantity("position", "rad", angle, drive.offset),
        _TARGETS["csp"]: Quantity("target position", "rad", angle, drive.offset),
        _TARGETS["csv"]: Quantity("target velocity", "rad/s", speed),
        _FEEDBACK["velocity"]: Quantity("velocity", "rad/s", speed),
        _FEEDBACK["torque"]: Quantity("torque", "N m", None),
        _FEEDBACK["error_code"]: Quantity("error", words=_error_words),
        _FEEDBACK["demand"]: Quantity("demand", "rad", angle, drive.offset),
        DIGITAL_INPUTS: Quantity("inputs", words=_input_words),
    }


def _torque_factor(drive: DriveSettings) -> float:
    """Return the joint's torque (N m) for one count of 0x6077 and one mN m rated torque."""
    return (-1.0 if drive.reversed else 1.0) * drive.gear * 1e-6


def _control_words(word: int) -> str:
    names = {0x00: "disable voltage", 0x02: "quick stop", 0x06: "shutdown", 0x07: "switch on"}
    return {**names, 0x0F: "enable operation", 0x80: "fault reset"}.get(word, f"0x{word:04X}")


def _status_words(word: int) -> str:
    state = decode_state(word)
    return f"0x{word:04X} {'no state' if state is None else state.name.replace('_', ' ')}"


def _input_words(inputs: int) -> str:
    return f"0x{inputs:08X}"


def _mode_words(mode: int) -> str:
    return {8: "csp", 9: "csv"}.get(mode, str(mode))


def _error_words(code: int) -> str:
    return "none" if code == 0 else f"0x{code:04X} {describe_error(code)}"
