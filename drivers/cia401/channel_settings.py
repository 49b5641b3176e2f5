"""One channel of a CiA 401 module: what commands it, what it reports, what keeps it safe."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Final, Literal

from annotated_types import Interval, Unit

from drivers.canopen.mapping import RANGES, DataTypeName, Entry
from rig.hal.rules import Rules

_Pascal = Annotated[float, Unit("Pa")]
_Volt = Annotated[float, Unit("V")]
_Ampere = Annotated[float, Unit("A")]
_Opening = Annotated[float, Interval(ge=-1, le=1)]

_LEAST: Final = {
    "raw": 16.0, "float": 1e-6, "voltage": 0.1, "current": 1e-3, "pressure": 1e3, "opening": 0.1,
}  # fmt: skip
"""How far the ends of a line are apart, counts and SI: less is a number without its unit."""

DIGITAL_INPUT: Final = Entry(0x6000, 1, "u8")
DIGITAL_OUTPUT: Final = Entry(0x6200, 1, "u8")


@dataclass(frozen=True, slots=True, kw_only=True)
class AnalogueSignal:
    """One analogue channel: a straight line from counts over the wire to what they stand for.

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
    """

    stands_for: ClassVar[str]
    """The field with what it stands for at the two ends."""

    sub: Annotated[int, Interval(ge=0, le=254)]
    index: Annotated[int, Interval(ge=0x2000, le=0xFFFF)]
    type: DataTypeName = "i16"
    raw: tuple[float, float] = (0.0, 32767.0)
    voltage: tuple[_Volt, _Volt] | None = None
    current: tuple[_Ampere, _Ampere] | None = None

    def __post_init__(self) -> None:
        with Rules() as rule:
            if (self.voltage is None) == (self.current is None):
                rule.broken(
                    "give either voltage or current, the signal on the wire, and raw, its counts "
                    "at both ends."
                )
            lines = {
                "raw": self.raw,
                "voltage": self.voltage,
                "current": self.current,
                self.stands_for: self.ends,
            }
            for name, ends in lines.items():
                if ends is None:
                    continue
                low, high = ends
                # What it stands for may fall: a valve that is open without a signal.
                if low > high and name != self.stands_for:
                    rule.broken(
                        f"{name}: {low:g} … {high:g} does not rise; give the line's lower end "
                        f"first."
                    )
                # A floating-point object has no counts: volts, amperes or whatever its maker likes.
                least = _LEAST["float" if name == "raw" and self.type not in RANGES else name]
                if abs(high - low) < least:
                    rule.broken(
                        f"{name}: {low:g} … {high:g} is no line; its ends are at least {least:g} "
                        f"apart."
                    )
            if self.type in RANGES:
                low, high = RANGES[self.type]
                if not (low <= min(self.raw) and max(self.raw) <= high):
                    rule.broken(
                        f"raw: {self.raw[0]:g} … {self.raw[1]:g} does not fit into {self.type}, "
                        f"which holds {low} … {high}."
                    )

    @property
    def ends(self) -> tuple[float, float]:
        """What it stands for at the two ends."""
        ends: tuple[float, float] = getattr(self, self.stands_for)
        return ends

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
class PressureSignal(AnalogueSignal):
    """An analogue channel that stands for a pressure.

    Parameters
    ----------
    pressure : tuple of float
        The pressure at the two ends, Pa gauge.
    """

    stands_for = "pressure"
    pressure: tuple[_Pascal, _Pascal]


@dataclass(frozen=True, slots=True, kw_only=True)
class SetpointSignal(PressureSignal):
    """The analogue output that commands a regulator.

    Parameters
    ----------
    index : int
        Index of the object: 0x6411 on a CiA 401 module, or the maker's.
    """

    index: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] = 0x6411

    def __post_init__(self) -> None:
        with Rules() as rule:
            rule.of(PressureSignal.__post_init__, self)
            low, high = self.pressure
            if low > high:
                rule.broken(
                    f"pressure: {low:g} … {high:g} Pa falls; without a signal, as of a wire that "
                    "breaks, the regulator would give the most that it has. Give the lower end "
                    "first."
                )


@dataclass(frozen=True, slots=True, kw_only=True)
class OpeningSignal(AnalogueSignal):
    """The analogue output that commands the spool of a proportional valve.

    Parameters
    ----------
    index : int
        Index of the object: 0x6411 on a CiA 401 module, or the maker's.
    opening : tuple of float
        The opening at the two ends, -1 (exhaust) … 1 (feed). Where the lower end of the signal
        exhausts, a valve whose wire breaks or whose module is reset vents its chamber.
    """

    stands_for = "opening"
    index: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] = 0x6411
    opening: tuple[_Opening, _Opening] = (-1.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class MonitorSignal(PressureSignal):
    """The analogue input that reads a regulator's pressure monitor, or a chamber's sensor.

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

    def __post_init__(self) -> None:
        with Rules() as rule:
            rule.of(PressureSignal.__post_init__, self)
            low, high = self.pressure
            if low > high:
                rule.broken(f"pressure: {low:g} … {high:g} Pa falls; a monitor's rises.")

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
class ValveChannel:
    """One proportional valve, and the pressure sensor at its chamber.

    Parameters
    ----------
    setpoint : OpeningSignal
        What commands the spool.
    monitor : MonitorSignal
        What the sensor reports.
    """

    setpoint: OpeningSignal
    monitor: MonitorSignal


Channel = RegulatorChannel | ValveChannel
