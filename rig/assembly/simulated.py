"""Rigs without hardware: the only place outside of `drivers.sim` that knows the simulation."""

import itertools
import os
from typing import Any

from rig.assembly.parts import make_bus, make_devices, make_mechanism
from rig.assembly.registry import REGISTRY
from rig.assembly.rig import Backend, Rig
from rig.config import Profile
from rig.hal import ConfigurationError
from rig.runtime.columns import Column


def _make_plant(profile: Profile) -> Any:
    if profile.plant is None:
        raise ConfigurationError(
            f"the profile {profile.name} has no plant, so it cannot be simulated"
        )
    plant = REGISTRY.load("plant", profile.plant.model)
    return plant(profile.plant.settings, profile.simulation.seed)


def _truth_columns(plant: Any) -> tuple[Column, ...]:
    return tuple(
        Column(f"truth.{name}", unit, "true value in the simulated plant")
        for name, unit in plant.truth_columns
    )


def _wire(profile: Profile, plant: Any, name: str) -> tuple[Any, tuple[int, ...]]:
    from drivers.sim.wiring import WIRINGS, plant_channels

    entry = profile.devices[name]
    if entry.driver not in WIRINGS:
        raise ConfigurationError(f"{name}: there is no simulated device for {entry.driver}")
    mechanism = REGISTRY.load("mechanism", profile.mechanism)
    wired = mechanism.wiring(profile.mechanism_settings)
    own = tuple(getattr(entry.settings, "channels", ()))
    return WIRINGS[entry.driver], plant_channels(name, wired, plant, own)


def build_sim(profile: Profile) -> Rig:
    """Build a rig whose devices stand straight on the plant."""
    from drivers.sim.clock import SimClock
    from drivers.sim.faults import FaultSchedule, FaultyWorld

    plant = _make_plant(profile)
    devices: dict[str, Any] = {}
    clock = SimClock(plant)
    for name, entry in profile.devices.items():
        wiring, channels = _wire(profile, plant, name)
        devices[name] = wiring.simulate(name, entry.settings, plant, channels, clock)
    if profile.simulation.faults:
        targets = {**devices, "plant": plant}
        clock.world = FaultyWorld(plant, _schedule(FaultSchedule, profile, targets))
    return Rig(
        profile,
        Backend.SIM,
        clock=clock,
        buses={},
        devices=devices,
        mechanism=make_mechanism(profile, devices),
        truth_columns=_truth_columns(plant),
        truth=plant.truth,
    )


_virtual_channels = itertools.count()


def build_virtual(profile: Profile) -> Rig:
    """Build a rig with production drivers against emulated nodes, in virtual time."""
    import can

    from drivers.sim.clock import SimClock
    from drivers.sim.emulated_bus import EmulatedBus
    from drivers.sim.emulation import EmulatedRig

    plant = _make_plant(profile)
    run = f"rig-{os.getpid()}-{next(_virtual_channels)}"
    ends = []
    emulated = []
    for bus in profile.buses:
        nodes = []
        for name, entry in profile.devices.items():
            if entry.bus == bus:
                wiring, channels = _wire(profile, plant, name)
                nodes.append(
                    wiring.emulate(name, entry.settings, plant, channels, entry.serial or 0)
                )
        end = can.Bus(interface="virtual", channel=f"{run}-{bus}", ignore_config=True)
        ends.append(end)
        emulated.append(EmulatedBus(bus, end, nodes))  # type: ignore[arg-type]
    world = _schedule(EmulatedRig, profile, plant, emulated)
    clock = SimClock(world)
    on = {name: {"interface": "virtual", "channel": f"{run}-{name}"} for name in profile.buses}
    buses = {name: make_bus(name, bus, clock, on[name]) for name, bus in profile.buses.items()}
    devices = make_devices(profile, buses)

    def release() -> None:
        for end in ends:
            end.shutdown()

    return Rig(
        profile,
        Backend.VIRTUAL,
        clock=clock,
        buses=buses,
        devices=devices,
        mechanism=make_mechanism(profile, devices),
        truth_columns=_truth_columns(plant),
        truth=plant.truth,
        release=release,
    )


def _schedule(kind: Any, profile: Profile, *parts: Any) -> Any:
    """Build something with a fault schedule; an impossible fault is a configuration error."""
    try:
        if kind.__name__ == "EmulatedRig":
            plant, buses = parts
            return kind(plant, buses, profile.simulation, devices={"plant": plant})
        return kind(profile.simulation.faults, *parts)
    except ValueError as error:
        raise ConfigurationError(str(error)) from error
