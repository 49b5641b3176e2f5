"""From a profile's entries to production drivers and the mechanism."""

import dataclasses
from collections.abc import Mapping
from typing import Any

from rig.assembly.registry import REGISTRY
from rig.config import Profile
from rig.hal import Clock, ConfigurationError, CyclicBus, Device


def make_bus(
    name: str, settings: Any, clock: Clock, on: Mapping[str, Any] | None = None
) -> CyclicBus:
    """Make a bus, on another interface than the profile's if `on` says so."""
    from drivers.can import open_bus

    settings = dataclasses.replace(settings, **(on or {}))
    bus: CyclicBus = REGISTRY.load("bus", "can")(name, settings, lambda: open_bus(settings), clock)
    return bus


def make_devices(profile: Profile, buses: Mapping[str, CyclicBus]) -> dict[str, Device]:
    """Make the production driver of every device."""
    devices: dict[str, Device] = {}
    for name, entry in profile.devices.items():
        if entry.bus is None:
            raise ConfigurationError(f"{name}: the driver {entry.driver} needs a bus")
        driver = REGISTRY.load("driver", entry.driver)
        devices[name] = driver(name, entry.settings, buses[entry.bus], serial=entry.serial)
    return devices


def make_mechanism(profile: Profile, devices: Mapping[str, Device]) -> Any:
    """Make the loop's view of the rig."""
    mechanism = REGISTRY.load("mechanism", profile.mechanism)
    return mechanism.assemble(profile.mechanism_settings, devices, profile.loop.period)
