"""What a profile says of regulators behind a CiA 401 module."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Gt, Interval, MinLen, Unit

from drivers.cia401.channel_settings import Channel, RegulatorChannel
from drivers.cia401.module_settings import ModuleSettings
from rig.hal.rules import Rules


@dataclass(frozen=True, slots=True)
class FollowingSettings:
    """The bound beyond which a regulator that does not follow is a fault.

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
    time: Annotated[float, Unit("s"), Interval(ge=1e-3, le=60.0)] = 0.5
    response: Annotated[float, Unit("s"), Interval(ge=0, le=10.0)] = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Cia401Settings(ModuleSettings):
    """Regulators on a CiA 401 module, beside what `ModuleSettings` says.

    Parameters
    ----------
    channels : dict of str to RegulatorChannel
        The regulators by name.
    vented : float
        The safe setpoint, Pa gauge; the nearest that a channel can give is taken.
    following : FollowingSettings
        When a regulator that does not follow is a fault.
    """

    scaling = tuple(f"channels.*.*.{key}" for key in ("raw", "voltage", "current", "pressure"))

    channels: Annotated[dict[str, RegulatorChannel], MinLen(1)]
    vented: Annotated[float, Unit("Pa"), Interval(ge=0, le=50e3)] = 0.0
    following: FollowingSettings = field(default_factory=FollowingSettings)

    def __post_init__(self) -> None:
        with Rules() as rule:
            bits = {} if self.supply_bit is None else {self.supply_bit: "supply_bit"}
            for name, channel in self.channels.items():
                if channel.lock_bit is not None:
                    own = f"channels.{name}.lock_bit"
                    if bits.setdefault(channel.lock_bit, own) != own:
                        rule.broken(
                            f"{own}: output bit {channel.lock_bit} is that of "
                            f"{bits[channel.lock_bit]} already."
                        )
                elif channel.safe == "lock":
                    rule.broken(
                        f"channels.{name}: safe is lock, but nothing locks it; give lock_bit, the "
                        "output of the valve between regulator and chamber, or take vent or hold."
                    )
                if channel.safe == "hold" and self.error_mode is None:
                    rule.broken(
                        f"channels.{name}: safe is hold, but without error_mode the module "
                        "cannot be told to hold its output when the master falls silent."
                    )
            low, high = self.pressure_range
            if not low < high:
                rule.broken("channels: their setpoints have no pressure range in common.")
            if not self.following.deviation < high - low:
                rule.broken(
                    f"following.deviation ({self.following.deviation:g} Pa) is not below the "
                    f"range of the setpoints ({high - low:g} Pa): the alarm could never trip."
                )
            rule.of(ModuleSettings.__post_init__, self)

    @property
    def wired(self) -> Mapping[str, Channel]:
        """See `ModuleSettings.wired`."""
        return self.channels

    def kept_channels(self) -> tuple[str, ...]:
        """Return the channels that are not vented in the safe state."""
        return tuple(name for name, channel in self.channels.items() if channel.safe != "vent")

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
