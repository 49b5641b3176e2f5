"""Buses of a profile: made, and their load computed, by the row of what is spoken on them."""

import dataclasses
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rig.assembly.registry import REGISTRY
from rig.assembly.rows import load
from rig.config import BusEntry, Profile
from rig.hal import BusLoad, Clock, CyclicBus, DriverSettings


def is_can(entry: BusEntry) -> bool:
    """Return whether a bus runs on a CAN interface."""
    return REGISTRY.protocol(entry.protocol).is_can


def make_bus(
    name: str,
    entry: BusEntry,
    clock: Clock,
    period: float,
    on: Mapping[str, Any] | None = None,
    opened: Callable[[], Any] | None = None,
    frames: Any = None,
) -> CyclicBus:
    """Make a bus.

    Parameters
    ----------
    name : str
        Its name in the profile.
    entry : BusEntry
        Protocol and settings.
    clock : Clock
        The rig's.
    period : float
        Of the loop, s.
    on : mapping, optional
        Settings that replace the profile's: another interface.
    opened : callable, optional
        Returns the interface, in the place of the real one.
    frames : FrameLog, optional
        Records what passes on a CAN interface, see `drivers.can.frame_log`.
    """
    settings = dataclasses.replace(entry.settings, **(on or {}))
    open_interface = load(REGISTRY.protocol(entry.protocol).open)
    opened = opened or (lambda: open_interface(settings))
    if frames is not None and is_can(entry):
        opened = partial(_open_recorded, frames, name, clock, opened)
    bus: CyclicBus = REGISTRY.load("bus", entry.protocol)(name, settings, opened, clock, period)
    return bus


def _open_recorded(frames: Any, name: str, clock: Clock, opened: Callable[[], Any]) -> Any:
    return frames.tap(name, clock, opened())


def bus_loads(profile: Profile) -> dict[str, BusLoad]:
    """Return the worst-case load of each bus of a profile.

    Raises
    ------
    ConfigurationError
        A bus has more to carry than its `max_load`.
    """
    return {
        name: load(REGISTRY.protocol(entry.protocol).load)(
            name, entry.settings, _devices_on(profile, name), profile.loop.rate
        )
        for name, entry in profile.buses.items()
    }


def _devices_on(profile: Profile, bus: str) -> list[tuple[str, DriverSettings]]:
    return [(name, entry.settings) for name, entry in profile.devices.items() if entry.bus == bus]
