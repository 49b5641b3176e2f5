"""What a profile says of proportional valves behind a CiA 401 module."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Final

from annotated_types import MinLen

from drivers.cia401.channel_settings import Channel, ValveChannel
from drivers.cia401.module_settings import ModuleSettings
from rig.hal.rules import Rules

EXHAUSTED: Final = -1.0
"""The opening that vents a chamber: the safe state."""

_LEAST_FEED: Final = 0.1
"""Opening that a valve has to be able to reach; the dead zone of one is some hundredths."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cia401ValvesSettings(ModuleSettings):
    """Proportional valves on a CiA 401 module, beside what `ModuleSettings` says.

    Parameters
    ----------
    channels : dict of str to ValveChannel
        The valves by name.
    """

    scaling = tuple(
        f"channels.*.*.{key}" for key in ("raw", "voltage", "current", "opening", "pressure")
    )

    channels: Annotated[dict[str, ValveChannel], MinLen(1)]

    def __post_init__(self) -> None:
        with Rules() as rule:
            rule.of(ModuleSettings.__post_init__, self)
            for name, channel in self.channels.items():
                if EXHAUSTED not in channel.setpoint.ends:
                    low, high = sorted(channel.setpoint.ends)
                    rule.broken(
                        f"channels.{name}.setpoint.opening: {low:g} … {high:g} does not reach "
                        f"{EXHAUSTED:g}, the exhaust: the chamber could not be vented."
                    )
                if max(channel.setpoint.ends) < _LEAST_FEED:
                    rule.broken(
                        f"channels.{name}.setpoint.opening: it ends at "
                        f"{max(channel.setpoint.ends):g}, and from {_LEAST_FEED:g} on a valve "
                        "feeds: the chamber could not be filled."
                    )

    @property
    def wired(self) -> Mapping[str, Channel]:
        """See `ModuleSettings.wired`."""
        return self.channels

    @property
    def opening_range(self) -> tuple[float, float]:
        """The openings that every valve can be given."""
        ends = [sorted(channel.setpoint.ends) for channel in self.channels.values()]
        return max(low for low, _ in ends), min(high for _, high in ends)

    @property
    def sensor_range(self) -> tuple[float, float]:
        """The pressures that every sensor shows, Pa gauge."""
        ends = [channel.monitor.pressure for channel in self.channels.values()]
        return max(low for low, _ in ends), min(high for _, high in ends)
