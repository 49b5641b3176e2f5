"""What a profile says of a CiA 401 module with electro-pneumatic regulators on it."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

from annotated_types import Ge, Gt, Interval, MinLen, Unit

from drivers.canopen.mapping import (
    RANGES,
    DataTypeName,
    Entry,
    Layout,
    layout_size,
    pack,
)

if TYPE_CHECKING:
    from drivers.canopen.described import DescribedNode
    from drivers.canopen.eds_check import DeviceFile

_Pascal = Annotated[float, Unit("Pa")]
_Volt = Annotated[float, Unit("V")]
_Ampere = Annotated[float, Unit("A")]

DIGITAL_INPUT: Final = Entry(0x6000, 1, "u8")
DIGITAL_OUTPUT: Final = Entry(0x6200, 1, "u8")


@dataclass(frozen=True, slots=True, kw_only=True)
class AnalogueSignal:
    """One analogue channel: a straight line from counts over the wire to pressure.

    Parameters
    ----------
    sub : int
        Sub-index of the channel's object, which is the channel's number on most modules.
    index : int
        Index of the object.
    type : str
        Its data type.
    raw : tuple of float
        The converter's counts at the two ends.
    voltage, current : tuple of float, optional
        The signal at the two ends, V or A: one of the two.
    pressure : tuple of float
        The pressure at the two ends, Pa gauge.
    """

    sub: Annotated[int, Interval(ge=0, le=254)]
    index: Annotated[int, Interval(ge=0x2000, le=0xFFFF)]
    type: DataTypeName = "i16"
    raw: tuple[float, float] = (0.0, 32767.0)
    voltage: tuple[_Volt, _Volt] | None = None
    current: tuple[_Ampere, _Ampere] | None = None
    pressure: tuple[_Pascal, _Pascal]

    def __post_init__(self) -> None:
        if (self.voltage is None) == (self.current is None):
            raise ValueError("give either voltage or current, the signal on the wire.")
        for name, (low, high) in (
            ("raw", self.raw),
            ("current" if self.voltage is None else "voltage", self.signal),
            ("pressure", self.pressure),
        ):
            if low == high:
                raise ValueError(f"{name}: both ends are {low:g}; a line needs two points.")
        if self.type in RANGES:
            low, high = RANGES[self.type]
            if not (low <= min(self.raw) and max(self.raw) <= high):
                raise ValueError(
                    f"raw: {self.raw[0]:g} … {self.raw[1]:g} does not fit into {self.type}, "
                    f"which holds {low} … {high}."
                )

    @property
    def signal(self) -> tuple[float, float]:
        """The signal at the two ends, V or A."""
        ends = self.voltage if self.current is None else self.current
        assert ends is not None
        return ends

    @property
    def signal_unit(self) -> str:
        """``"V"`` or ``"A"``."""
        return "V" if self.current is None else "A"

    @property
    def entry(self) -> Entry:
        """The object, as it is mapped into a PDO."""
        return Entry(self.index, self.sub, self.type)


@dataclass(frozen=True, slots=True, kw_only=True)
class SetpointSignal(AnalogueSignal):
    """The analogue output that commands a regulator.

    Parameters
    ----------
    index : int
        Index of the object: 0x6411 on a CiA 401 module, or the maker's.
    """

    index: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] = 0x6411


@dataclass(frozen=True, slots=True, kw_only=True)
class MonitorSignal(AnalogueSignal):
    """The analogue input that reads a regulator's pressure monitor.

    Parameters
    ----------
    index : int
        Index of the object: 0x6401 on a CiA 401 module, or the maker's.
    wire_break : float, optional
        Share of the lower end's signal below which the wire is broken. Needs a live zero
        (4 … 20 mA, 1 … 5 V). None: 0.9 for a current (3.6 mA, NAMUR NE 43), 0.5 for a
        voltage. 0: not checked.
    """

    index: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] = 0x6401
    wire_break: Annotated[float, Unit("1"), Interval(ge=0, lt=1)] | None = None

    @property
    def broken_below(self) -> float:
        """The signal below which the wire is broken, V or A; 0 without a live zero."""
        zero = min(self.signal)
        if zero <= 0.0:
            return 0.0
        share = self.wire_break
        if share is None:
            share = 0.5 if self.current is None else 0.9
        return share * zero


@dataclass(frozen=True, slots=True)
class RegulatorChannel:
    """One regulator.

    Parameters
    ----------
    setpoint : SetpointSignal
        What commands it.
    monitor : MonitorSignal
        What it reports.
    safe : str
        What it does when the rig is made safe, or the master falls silent. ``vent``: the
        setpoint goes to `vented`. ``hold``: it keeps its last setpoint, and the supply stays
        open. ``lock``: the valve of `lock_bit` shuts the air in, and the setpoint goes to
        `vented` behind it.
    lock_bit : int, optional
        Bit of the first digital output byte that opens the valve between the regulator and its
        chamber; low shuts it.
    """

    setpoint: SetpointSignal
    monitor: MonitorSignal
    safe: Literal["vent", "hold", "lock"] = "vent"
    lock_bit: Annotated[int, Interval(ge=0, le=7)] | None = None


@dataclass(frozen=True, slots=True)
class FollowingSettings:
    """When a regulator that does not follow its setpoint is a fault.

    The monitored pressure is compared with the setpoint passed through a first-order lag.

    Parameters
    ----------
    deviation : float
        Permitted distance, Pa.
    time : float
        For how long it may be exceeded, s.
    response : float
        Time constant of the lag, s.
    """

    deviation: Annotated[float, Unit("Pa"), Gt(0)] = 50e3
    time: Annotated[float, Unit("s"), Gt(0)] = 0.5
    response: Annotated[float, Unit("s"), Ge(0)] = 0.1


@dataclass(frozen=True, slots=True)
class Cia401Settings:
    """A CiA 401 module: regulators on its analogue, safety on its digital channels.

    Parameters
    ----------
    node : int
        Its number on the bus.
    channels : dict of str to RegulatorChannel
        The regulators by name.
    supply_bit : int, optional
        Bit of the first digital output byte that opens the supply (and dump) valve.
    stop_bit : int, optional
        Bit of the first digital input byte that reads the emergency-stop contact.
    stop_active_low : bool
        The contact is normally closed: the bit is 0 when the stop is pressed.
    vented : float
        The safe setpoint, Pa gauge; the nearest that a channel can give is taken.
    error_mode, error_value : int, optional
        The objects that say what an output does when the node leaves OPERATIONAL: 0x6443
        and 0x6444 on a CiA 401 module (0x6445 for f32 outputs). They are written and read
        back at each start. None: the module has none, and holds or drops its outputs as
        its maker decided.
    error_mode_type : str
        Data type of the error mode; some makers took u16.
    following : FollowingSettings
        When a regulator that does not follow is a fault.
    vendor, product : int, optional
        What the module must report in 0x1018.
    eds : str, optional
        The device's own EDS file, relative to this one: types are taken from it, and what it
        says the device cannot do is refused.
    remap : bool
        Write the PDO mapping; False for modules whose mapping is fixed, which is then
        compared.
    hold_after, fault_after : int
        Readings missed in a row that are counted as held, and that are a fault.
    """

    node: Annotated[int, Interval(ge=1, le=127)]
    channels: Annotated[dict[str, RegulatorChannel], MinLen(1)]
    supply_bit: Annotated[int, Interval(ge=0, le=7)] | None = None
    stop_bit: Annotated[int, Interval(ge=0, le=7)] | None = None
    stop_active_low: bool = True
    vented: Annotated[float, Unit("Pa")] = 0.0
    error_mode: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] | None = 0x6443
    error_value: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] | None = 0x6444
    error_mode_type: Literal["u8", "u16"] = "u8"
    following: FollowingSettings = field(default_factory=FollowingSettings)
    vendor: Annotated[int, Interval(ge=0, le=0xFFFF_FFFF)] | None = None
    product: Annotated[int, Interval(ge=0, le=0xFFFF_FFFF)] | None = None
    eds: str | None = None
    remap: bool = True
    hold_after: Annotated[int, Ge(1)] = 2
    fault_after: Annotated[int, Ge(1)] = 5

    def __post_init__(self) -> None:
        for side in ("setpoint", "monitor"):
            owner: dict[Entry, str] = {}
            for name, channel in self.channels.items():
                entry = getattr(channel, side).entry
                if entry in owner:
                    raise ValueError(
                        f"channels {owner[entry]} and {name} have the same {side} object {entry}."
                    )
                owner[entry] = name
        bits = {} if self.supply_bit is None else {self.supply_bit: "supply_bit"}
        for name, channel in self.channels.items():
            if channel.lock_bit is not None:
                own = f"channels.{name}.lock_bit"
                if bits.setdefault(channel.lock_bit, own) != own:
                    raise ValueError(
                        f"{own}: output bit {channel.lock_bit} is that of "
                        f"{bits[channel.lock_bit]} already."
                    )
            elif channel.safe == "lock":
                raise ValueError(
                    f"channels.{name}: safe is lock, but nothing locks it; give lock_bit, the "
                    "output of the valve between regulator and chamber, or take vent or hold."
                )
            if channel.safe == "hold" and self.error_mode is None:
                raise ValueError(
                    f"channels.{name}: safe is hold, but without error_mode the module cannot be "
                    "told to hold its output when the master falls silent."
                )
        low, high = self.pressure_range
        if not low < high:
            raise ValueError("channels: their setpoints have no pressure range in common.")
        if self.fault_after < self.hold_after:
            raise ValueError(
                f"fault_after ({self.fault_after}) is below hold_after ({self.hold_after})."
            )
        pack(self.receive_entries)
        pack(self.transmit_entries)

    @property
    def pressure_range(self) -> tuple[float, float]:
        """The setpoints that every channel can give, Pa gauge."""
        scales = [sorted(channel.setpoint.pressure) for channel in self.channels.values()]
        return max(low for low, _ in scales), min(high for _, high in scales)

    @property
    def opening_bits(self) -> int:
        """The digital output bits that a rig in use has high: supply and lock valves."""
        bits = [self.supply_bit, *(channel.lock_bit for channel in self.channels.values())]
        return sum(1 << bit for bit in bits if bit is not None)

    @property
    def kept_bits(self) -> int:
        """Those that stay as they are in the safe state."""
        channels = self.channels.values()
        kept = [channel.lock_bit for channel in channels if channel.safe != "lock"]
        if any(channel.safe == "hold" for channel in channels):
            kept.append(self.supply_bit)
        return sum(1 << bit for bit in kept if bit is not None)

    @property
    def receive_entries(self) -> Layout:
        """What the module receives each cycle, in order."""
        digital = (DIGITAL_OUTPUT,) if self.opening_bits else ()
        return (*(channel.setpoint.entry for channel in self.channels.values()), *digital)

    @property
    def transmit_entries(self) -> Layout:
        """What the module sends each cycle, in order."""
        digital = () if self.stop_bit is None else (DIGITAL_INPUT,)
        return (*(channel.monitor.entry for channel in self.channels.values()), *digital)

    def cyclic_frames(self) -> tuple[tuple[str, int], ...]:
        """Return what the module puts on the bus each cycle: names and bytes."""
        return (
            *(
                (f"RPDO{n} setpoints", layout_size(layout))
                for n, layout in enumerate(pack(self.receive_entries), 1)
            ),
            *(
                (f"TPDO{n} monitors", layout_size(layout))
                for n, layout in enumerate(pack(self.transmit_entries), 1)
            ),
        )

    @staticmethod
    def read_eds(path: Path) -> "DeviceFile":
        """Read the module's own EDS.

        Raises
        ------
        EdsError
            It cannot be read or understood.
        """
        from drivers.canopen.eds_check import DeviceFile
        from drivers.cia401.described import typed_objects

        return DeviceFile(path, typed_objects)

    def describe_nodes(self, name: str) -> "tuple[DescribedNode, ...]":
        """Return what the module exchanges and what its counts mean.

        Parameters
        ----------
        name : str
            The device's name in the profile.
        """
        from drivers.cia401.described import describe_nodes

        return describe_nodes(self, name)
