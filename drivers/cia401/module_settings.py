"""What a profile says of a CiA 401 module, whatever hangs on its analogue channels."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Final, Literal

from annotated_types import Interval, Unit

from drivers.can.milliseconds import check_milliseconds
from drivers.canopen.described import DescribedNode
from drivers.canopen.mapping import SIZES, Entry, Layout, pack
from drivers.canopen.node_settings import NodeSettings
from drivers.canopen.settings import CanBusSettings
from drivers.cia401.channel_settings import DIGITAL_INPUT, DIGITAL_OUTPUT, Channel
from drivers.cia401.described import describe_channels, mapped_settings, typed_objects
from rig.hal import Address, ConfigurationError
from rig.hal.rules import Rules

PROFILE: Final = 401
"""CiA's number of the device profile."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleSettings(NodeSettings):
    """A CiA 401 module: actuators on its analogue, safety on its digital channels.

    Parameters
    ----------
    node : int
        Its number on the bus.
    supply_bit : int, optional
        Bit of the first digital output byte that opens the supply (and dump) valve.
    stop_bit : int, optional
        Bit of the first digital input byte that reads the emergency-stop contact.
    stop_active_low : bool
        The contact is normally closed: the bit is 0 when the stop is pressed.
    error_mode, error_value : int, optional
        The objects that say what an output does when the node leaves OPERATIONAL: 0x6443
        and 0x6444 on a CiA 401 module (0x6445 for f32 outputs). They are written and read
        back at each start. None: the module has none, and holds or drops its outputs as
        its maker decided.
    error_mode_type : str
        Data type of the error mode; some makers took u16.
    setpoint_deadline : float, optional
        After so long without setpoints the module itself takes its error values, s: 0x1400:5 of
        each receive PDO, in whole milliseconds. None: it is not used, and the heartbeat alone ends
        the last setpoints. Only for a module that acts on it; not each that has the object does.
    echo : bool
        The module sends the setpoints that it has got back each cycle, if its outputs can be
        mapped: those that do not arrive, or come late, are found. It costs as many bytes again.
    """

    node: Annotated[int, Interval(ge=1, le=127)]
    supply_bit: Annotated[int, Interval(ge=0, le=7)] | None = None
    stop_bit: Annotated[int, Interval(ge=0, le=7)] | None = None
    stop_active_low: bool = True
    error_mode: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] | None = 0x6443
    error_value: Annotated[int, Interval(ge=0x2000, le=0xFFFF)] | None = 0x6444
    error_mode_type: Literal["u8", "u16"] = "u8"
    setpoint_deadline: Annotated[float, Unit("s"), Interval(ge=1e-3, le=1.0)] | None = None
    echo: bool = False

    def __post_init__(self) -> None:
        with Rules() as rule:
            sides = {
                "setpoint": {name: of.setpoint.entry for name, of in self.wired.items()},
                "monitor": {name: of.monitor.entry for name, of in self.wired.items()},
            }
            for side, entries in sides.items():
                owner: dict[Entry, str] = {}
                for name, entry in entries.items():
                    if entry in owner:
                        rule.broken(
                            f"channels {owner[entry]} and {name} have the same {side} object "
                            f"{entry}."
                        )
                    owner[entry] = name
            if self.setpoint_deadline is not None:
                rule.of(
                    check_milliseconds, "setpoint_deadline", self.setpoint_deadline,
                    "object 0x1400:05",
                )  # fmt: skip
            rule.of(NodeSettings.__post_init__, self)
            rule.of(pack, self.receive_entries)
            rule.of(pack, self.transmit_entries)

    @property
    def wired(self) -> Mapping[str, Channel]:
        """Its channels by name, whatever they are."""
        raise NotImplementedError

    @property
    def opening_bits(self) -> int:
        """The digital output bits that a rig in use has high."""
        return 0 if self.supply_bit is None else 1 << self.supply_bit

    @property
    def kept_bits(self) -> int:
        """Those that stay as they are in the safe state."""
        return 0

    @property
    def receive_entries(self) -> Layout:
        """What the module receives each cycle, in order."""
        digital = (DIGITAL_OUTPUT,) if self.opening_bits else ()
        return (*(channel.setpoint.entry for channel in self.wired.values()), *digital)

    def stop_place(self, name: str) -> str:
        """Return where a device of that name reads the emergency stop, for messages."""
        where = f"{name} (node 0x{self.node:02X})"
        if self.stop_bit is None:
            return where
        return f"{where} at bit {self.stop_bit} of its inputs [object {DIGITAL_INPUT}]"

    @property
    def transmit_entries(self) -> Layout:
        """What the module sends each cycle, in order."""
        channels = self.wired.values()
        digital = () if self.stop_bit is None else (DIGITAL_INPUT,)
        echoes = tuple(channel.setpoint.entry for channel in channels) if self.echo else ()
        return (*(channel.monitor.entry for channel in channels), *echoes, *digital)

    def channel_names(self) -> tuple[str, ...]:
        """Return the channels' names."""
        return tuple(self.wired)

    def confirmed_bytes(self) -> tuple[bool, ...]:
        """Return which bytes of its first frame of setpoints the module echoes.

        Those of analogue outputs; of digital ones, like the supply valve's, nothing comes back.
        """
        first = pack(self.receive_entries)[0] if self.echo else ()
        return tuple(entry != DIGITAL_OUTPUT for entry in first for _ in range(SIZES[entry.type]))

    def acts_after(self, bus: object) -> float | None:
        """Return after how long without the program it makes itself safe, s.

        By its heartbeat, or by the deadline of its setpoints if that is shorter.
        """
        ends = [bus.heartbeat_timeout] if isinstance(bus, CanBusSettings) else []
        if self.setpoint_deadline is not None:
            ends.append(self.setpoint_deadline)
        return min(ends, default=None)

    def check_deadline(self, device: str, period: float | None) -> None:
        """Raise if one lost setpoint would pass the deadline.

        Raises
        ------
        ConfigurationError
        """
        deadline = self.setpoint_deadline
        if deadline is not None and period is not None and deadline < 2.0 * period:
            raise ConfigurationError(
                f"{device}: setpoint_deadline ({deadline:g} s) is less than two cycles of "
                f"{period:g} s; one lost setpoint would stop the rig."
            )

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return the module's node."""
        return (Address(device, self.node, PROFILE, self.vendor, self.product, serial),)

    typed_objects = staticmethod(typed_objects)
    mapped_settings = staticmethod(mapped_settings)

    def describe_nodes(self, name: str) -> tuple[DescribedNode, ...]:
        """Return what the module exchanges and what its counts mean."""
        stop = None if self.stop_bit is None else (self.stop_bit, self.stop_active_low)
        quantities, origins = describe_channels(self.wired, self.supply_bit, stop)
        return (
            DescribedNode(
                name,
                self.node,
                pack(self.receive_entries),
                pack(self.transmit_entries),
                self.remap,
                quantities,
                origins,
                deadline=self.setpoint_deadline is not None,
                contents=("setpoints", "monitors"),
            ),
        )
