"""From a profile's entries to production drivers and the mechanism."""

import dataclasses
from collections.abc import Mapping
from typing import Any

from rig.assembly.registry import REGISTRY
from rig.config import BusEntry, Profile
from rig.hal import Clock, ConfigurationError, CyclicBus, Device, MotionRefused
from rig.runtime.motion import Motion


def make_bus(
    name: str, entry: BusEntry, clock: Clock, on: Mapping[str, Any] | None = None
) -> CyclicBus:
    """Make a bus, on another interface than the profile's if `on` says so."""
    from drivers.can import open_bus

    settings = dataclasses.replace(entry.settings, **(on or {}))
    kind = REGISTRY.load("bus", entry.protocol)
    bus: CyclicBus = kind(name, settings, lambda: open_bus(settings), clock)
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


def make_controller(profile: Profile, name: str) -> Any:
    """Make a controller with the profile's settings, for the profile's mechanism.

    Raises
    ------
    ConfigurationError
        The profile has no settings for it.
    """
    if name not in profile.controllers:
        raise ConfigurationError(
            f"the profile {profile.name} has no controller {name!r}; "
            f"it has {', '.join(profile.controllers)}"
        )
    model = REGISTRY.load("mechanism", profile.mechanism).model_of(profile.mechanism_settings)
    return REGISTRY.load("controller", name)(profile.controllers[name], model, profile.loop.period)


def plan_motion(profile: Profile, reference: Any, controller: Any) -> Motion[Any]:
    """Turn an experiment's reference into a motion of the profile's mechanism.

    Raises
    ------
    MotionRefused
        The rig cannot or must not move so.
    """
    mechanism = REGISTRY.load("mechanism", profile.mechanism)
    try:
        motion: Motion[Any] = mechanism.plan(
            profile.mechanism_settings, reference, controller, profile.loop.period
        )
    except ValueError as error:
        raise MotionRefused(str(error)) from error
    return motion
