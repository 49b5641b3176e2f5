"""The rig that is broken: what it has that may break, and how it runs when nothing does."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from rig.hal.hazards import Hazard
from rig.hal.world import BreakableWorld, Frames


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """A rig under test, as it was seen in a run without faults.

    Parameters
    ----------
    rig : str
        The profile's name.
    experiments : tuple of str
        What it may be doing when something breaks.
    period : float
        Of its loop, s.
    channels : mapping
        Names of each device's channels or axes, and of the plant's.
    knows : mapping
        Faults that each device, each bus and the plant can suffer.
    frames : mapping
        The CAN identifiers of the devices that have some.
    on_bus : mapping
        Names of the devices on each bus.
    hazards : tuple of Hazard
        What must never be true.
    base_pressure : float
        What its chambers hold at rest, Pa gauge; infinite without chambers.
    by_velocity : frozenset of str
        Devices whose axes their velocity loops alone can hold.
    confirming : mapping
        Which bytes of their first frame of setpoints those devices send back that send back any.
    connecting : float
        How long it takes until it is energised, s.
    reading_age : float
        Oldest reading that its loop goes on with, s.
    procedures : mapping
        How long each procedure that calibrates it by moving it takes, s.
    chosen : tuple of str
        The experiments, if somebody chose them.
    configs : str
        The folder of the configurations, if somebody named it.
    """

    rig: str
    experiments: tuple[str, ...]
    period: float
    channels: Mapping[str, tuple[str, ...]]
    knows: Mapping[str, tuple[str, ...]]
    frames: Mapping[str, Frames]
    on_bus: Mapping[str, tuple[str, ...]]
    hazards: tuple[Hazard, ...]
    connecting: float
    reading_age: float
    base_pressure: float = math.inf
    by_velocity: frozenset[str] = frozenset()
    confirming: Mapping[str, tuple[bool, ...]] = field(default_factory=dict)
    procedures: Mapping[str, float] = field(default_factory=dict)
    chosen: tuple[str, ...] = ()
    configs: str = ""

    @property
    def has_pressure(self) -> bool:
        """Whether it has chambers, which are filled while it is energised."""
        return any(hazard.name == "pressure" for hazard in self.hazards)

    def opposite(self, axis: str) -> str:
        """Return the channel of the plant that pulls against `axis`; itself where none does.

        A pneumatic plant names one chamber of each pair, then in the same order the others.
        """
        channels = self.channels.get("plant", ())
        if axis not in channels:
            return axis
        return channels[(channels.index(axis) + len(channels) // 2) % len(channels)]

    def words_of(self, bus: str) -> tuple[str, ...]:
        """Return names that stand for a bus: its own, and those of all that is on it."""
        devices = self.on_bus.get(bus, ())
        axes = [axis for device in devices for axis in self.channels.get(device, ())]
        return (bus, *devices, *axes)


def frames_in(world: BreakableWorld) -> dict[str, Frames]:
    """Return the identifiers of every device that has CAN frames."""
    found = {name: world.frames_of(name) for name in world.known_faults}
    return {name: frames for name, frames in found.items() if frames is not None}
