"""What a profile says of a CiA 406 linear encoder."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Final, Literal

from annotated_types import Ge, Gt, Interval, Unit

from drivers.canopen.described import DescribedNode, Quantity, Told
from drivers.canopen.mapping import DataTypeName, Entry, Layout, MappedObjects, pack
from drivers.canopen.node_settings import NodeSettings
from rig.hal import Address
from rig.hal.driver import Keys, Scalar
from rig.hal.rules import Rules

_POSITIONS, _SPEED, _ALARMS = (0x6004, 0x6020), 0x6030, 0x6503
PROFILE: Final = 406
"""CiA's number of the device profile."""


@dataclass(frozen=True, slots=True)
class PositionObject:
    """The object that holds the position.

    Parameters
    ----------
    index, sub : int
        0x6004:0, or 0x6020:k on encoders with several sensors, or the maker's.
    type : str
        Its data type.
    """

    index: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] = 0x6004
    sub: Annotated[int, Interval(ge=0, le=254)] = 0
    type: DataTypeName = "i32"


@dataclass(frozen=True, slots=True)
class SpeedObject:
    """The object that holds the speed.

    Parameters
    ----------
    index, sub : int
        0x6030:k, or the maker's.
    type : str
        Its data type.
    """

    index: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] = 0x6030
    sub: Annotated[int, Interval(ge=0, le=254)] = 1
    type: DataTypeName = "i16"


@dataclass(frozen=True, slots=True)
class Cia406Settings(NodeSettings):
    """A linear encoder after CiA 406, one rod per node.

    The rod's extension is ``± scale · step · counts + offset``.

    Parameters
    ----------
    node : int
        Its number on the bus.
    stroke : float
        The rod's travel, m.
    position : PositionObject
        Where the position is.
    speed : SpeedObject, optional
        Where the speed is; None if the device has none (null in a profile).
    alarms : str
        ``mapped`` into the PDO, ``polled`` once while connecting, or ``off``. A device's
        alarm also comes as an emergency message.
    step : float, optional
        Measuring step, m. None: read from 0x6005:1, which counts nanometres. Given: used,
        and compared with 0x6005:1 if the device has it.
    speed_step : float, optional
        The same for speed, m/s and 0x6005:2, which counts 0.01 mm/s.
    reversed : bool
        The device counts down as the rod extends.
    scale, offset : float
        Correction by calibration, 1 and m.
    overtravel : float
        How far a reading may lie outside 0 … `stroke`, m.
    max_speed : float
        A reading that implies a faster rod is a fault, m/s.
    frozen_timeout : float, optional
        A position that does not change in a single count for so long is a fault, s. Only
        for encoders with noise of their own: a rod may well stand still.
    preset_offset : int, optional
        What 0x6509 must hold, counts: somebody who set a preset has moved the zero.
    """

    scaling = ("step", "reversed", "scale", "offset")

    node: Annotated[int, Interval(ge=1, le=127)]
    stroke: Annotated[float, Unit("m"), Gt(0)]
    position: PositionObject = field(default_factory=PositionObject)
    speed: SpeedObject | None = field(default_factory=SpeedObject)
    alarms: Literal["mapped", "polled", "off"] = "mapped"
    step: Annotated[float, Unit("m"), Gt(0)] | None = None
    speed_step: Annotated[float, Unit("m/s"), Gt(0)] | None = None
    reversed: bool = False
    scale: Annotated[float, Unit("1"), Interval(ge=0.5, le=2.0)] = 1.0
    offset: Annotated[float, Unit("m")] = 0.0
    overtravel: Annotated[float, Unit("m"), Ge(0)] = 2e-3
    max_speed: Annotated[float, Unit("m/s"), Interval(ge=1e-3, le=20.0)] = 2.0
    frozen_timeout: Annotated[float, Unit("s"), Interval(ge=1e-3, le=60.0)] | None = None
    preset_offset: int | None = None

    def __post_init__(self) -> None:
        with Rules() as rule:
            rule.of(NodeSettings.__post_init__, self)
            if not self.overtravel < self.stroke:
                rule.broken(
                    f"overtravel ({self.overtravel:g} m) is not below stroke ({self.stroke:g} "
                    "m): a reading outside would never be a fault."
                )
            if len(pack(self.transmit_entries)) > 1:
                rule.broken(
                    "position, speed and alarms are more than the 8 bytes of one PDO; "
                    "set alarms to polled, or speed to null."
                )

    @property
    def transmit_entries(self) -> Layout:
        """What the encoder sends each cycle, in order."""
        entries = [Entry(self.position.index, self.position.sub, self.position.type)]
        if self.speed is not None:
            entries.append(Entry(self.speed.index, self.speed.sub, self.speed.type))
        if self.alarms == "mapped":
            entries.append(Entry(_ALARMS, 0, "u16"))
        return tuple(entries)

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return the encoder's node."""
        return (Address(device, self.node, PROFILE, self.vendor, self.product, serial),)

    @staticmethod
    def typed_objects(plain: Mapping[str, object]) -> dict[tuple[str, ...], tuple[int, int]]:
        """Return the objects whose types are settings, from the settings as they were written."""
        found: dict[tuple[str, ...], tuple[int, int]] = {}
        position, speed = PositionObject(), SpeedObject()
        for key, usual in (
            ("position", (position.index, position.sub)),
            ("speed", (speed.index, speed.sub)),
        ):
            written = plain.get(key, {})
            if isinstance(written, Mapping):  # null: the device has none
                index, sub = written.get("index", usual[0]), written.get("sub", usual[1])
                if isinstance(index, int) and isinstance(sub, int):
                    found[key, "type"] = index, sub
        return found

    @staticmethod
    def mapped_settings(plain: Mapping[str, object], objects: MappedObjects) -> dict[Keys, Scalar]:
        """Return where position, speed and alarms are, from what an encoder can send."""
        sent = objects.transmit
        position = next((its for its in sent if its.object in _POSITIONS), None)
        if position is None:
            return {}
        found: dict[Keys, Scalar] = {
            ("position", key): value for key, value in _place(position).items()
        }
        speed = next((its for its in sent if its.object == _SPEED), None)
        if speed is None:
            found["speed",] = None
        else:
            found |= {("speed", key): value for key, value in _place(speed).items()}
        alarms = any(its.object == _ALARMS for its in sent)
        found["alarms",] = "mapped" if alarms else "polled"
        return found

    def describe_nodes(self, name: str) -> tuple[DescribedNode, ...]:
        """Return what the encoder exchanges and what its counts mean."""
        factor = -self.scale if self.reversed else self.scale
        position, *others = self.transmit_entries
        quantities = {
            position: Quantity(
                "position", "m", None if self.step is None else factor * self.step, self.offset
            )
        }
        origins: dict[Entry, Keys] = {position: ("position",)}
        told = [Told(0x6005, 1, position, factor * 1e-9)]  # it counts nanometres
        if self.speed is not None:
            speed = others.pop(0)
            gain = None if self.speed_step is None else factor * self.speed_step
            quantities[speed] = Quantity("speed", "m/s", gain)
            origins[speed] = ("speed",)
            told.append(Told(0x6005, 2, speed, factor * 1e-5))  # 0.01 mm/s
        for alarms in others:
            quantities[alarms] = Quantity("alarms", words=lambda bits: f"0x{bits:04X}")
            origins[alarms] = ("alarms",)
        return (
            DescribedNode(
                name,
                self.node,
                (),
                (self.transmit_entries,),
                self.remap,
                quantities,
                origins,
                tuple(told),
                contents=("", "position"),
            ),
        )


def _place(entry: Entry) -> dict[str, int | str]:
    return {"index": entry.object, "sub": entry.sub, "type": entry.type}
