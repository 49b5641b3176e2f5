"""What a profile says of an inclinometer with gyroscopes after CiA 410."""

import math
from dataclasses import dataclass, field
from typing import Annotated, Final

from annotated_types import Gt, Interval, Le, Unit

from drivers.canopen.described import DescribedNode, Quantity
from drivers.canopen.mapping import DataTypeName, Entry, Layout, pack
from drivers.canopen.node_settings import NodeSettings
from rig.hal import Address
from rig.hal.rules import Rules

PROFILE: Final = 410
"""CiA's number of the device profile."""

_HUNDREDTH: Final = math.radians(0.01)


@dataclass(frozen=True, slots=True)
class AxisObject:
    """The object that holds one quantity.

    Parameters
    ----------
    index, sub : int
        Its address.
    type : str
        Its data type.
    reversed : bool
        It counts down where the robot's own axes count up.
    """

    index: Annotated[int, Interval(ge=0x2000, le=0xFFFF)]
    sub: Annotated[int, Interval(ge=0, le=254)] = 0
    type: DataTypeName = "i16"
    reversed: bool = False

    @property
    def entry(self) -> Entry:
        """The object, as it is mapped into a PDO."""
        return Entry(self.index, self.sub, self.type)

    @property
    def sign(self) -> float:
        """1, or -1 if it is reversed."""
        return -1.0 if self.reversed else 1.0


@dataclass(frozen=True, slots=True)
class Cia410Settings(NodeSettings):
    """A dynamic inclinometer: slopes after CiA 410, rates in its maker's objects.

    Parameters
    ----------
    node : int
        Its number on the bus.
    body : str
        What it is mounted on: the plant's channels are ``<body>_roll`` and so on.
    roll, pitch : AxisObject
        The slopes about the robot's x and y. CiA 410: 0x6010 and 0x6020.
    roll_rate, pitch_rate : AxisObject
        The rates about its x and y.
    step : float
        Of a slope, rad; compared with 0x6000, which counts thousandths of a degree.
    rate_step : float
        Of a rate, rad/s.
    roll_zero, pitch_zero : float
        What it shows when the body is upright, rad; it is taken off.
    frozen_timeout : float, optional
        If nothing changes in a single count for so long, that is a fault, s. None: it is not
        looked at.

    References
    ----------
    CiA 410 V1.2: 0x6000 resolution, 0x6010 slope long16, 0x6020 slope lateral16. DIS Sensors,
    "User manual QG65D CANopen dynamic inclinometer (type H) V2.3", section 8.3.5: rates in 0.01
    degrees a second at 0x6401:07 and :08, which the defaults are.
    """

    scaling = ("roll*", "pitch*", "step", "rate_step")

    node: Annotated[int, Interval(ge=1, le=127)]
    body: str = "waist"
    roll: AxisObject = field(default_factory=lambda: AxisObject(0x6010))
    pitch: AxisObject = field(default_factory=lambda: AxisObject(0x6020))
    roll_rate: AxisObject = field(default_factory=lambda: AxisObject(0x6401, 7))
    pitch_rate: AxisObject = field(default_factory=lambda: AxisObject(0x6401, 8))
    step: Annotated[float, Unit("rad"), Gt(0), Le(0.1)] = _HUNDREDTH
    rate_step: Annotated[float, Unit("rad/s"), Gt(0), Le(0.1)] = _HUNDREDTH
    roll_zero: Annotated[float, Unit("rad")] = 0.0
    pitch_zero: Annotated[float, Unit("rad")] = 0.0
    frozen_timeout: Annotated[float, Unit("s"), Interval(ge=1e-2, le=60.0)] | None = 0.1

    def __post_init__(self) -> None:
        with Rules() as rule:
            rule.of(NodeSettings.__post_init__, self)
            rule.of(pack, [axis.entry for axis in self.axes.values()])
            entries = [(axis.index, axis.sub) for axis in self.axes.values()]
            if len(set(entries)) < len(entries):
                rule.broken("roll, pitch and their rates: two of them are on one object.")

    @property
    def axes(self) -> dict[str, AxisObject]:
        """The objects by name, in the order in which they are sent."""
        return {
            "roll": self.roll,
            "pitch": self.pitch,
            "roll_rate": self.roll_rate,
            "pitch_rate": self.pitch_rate,
        }

    @property
    def layouts(self) -> tuple[Layout, ...]:
        """What the sensor sends each cycle, PDO by PDO."""
        return pack([axis.entry for axis in self.axes.values()])

    def channel_names(self) -> tuple[str, ...]:
        """Return the plant's channels that it measures."""
        return tuple(f"{self.body}_{name}" for name in self.axes)

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return the sensor's node."""
        return (Address(device, self.node, PROFILE, self.vendor, self.product, serial),)

    def describe_nodes(self, name: str) -> tuple[DescribedNode, ...]:
        """Return what the sensor exchanges and what its counts mean."""
        zeros = {"roll": self.roll_zero, "pitch": self.pitch_zero}
        quantities = {
            axis.entry: Quantity(
                quantity.replace("_", " "),
                "rad/s" if quantity.endswith("rate") else "rad",
                axis.sign * (self.rate_step if quantity.endswith("rate") else self.step),
                -zeros.get(quantity, 0.0),
            )
            for quantity, axis in self.axes.items()
        }
        origins = {axis.entry: (quantity,) for quantity, axis in self.axes.items()}
        return (
            DescribedNode(
                name,
                self.node,
                (),
                self.layouts,
                self.remap,
                quantities,
                origins,
                contents=("", "lean"),
            ),
        )
