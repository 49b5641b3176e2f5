"""A profile's plant and emulated nodes on real interfaces, for a rig in another process."""

import contextlib
import dataclasses
from collections.abc import Iterator
from typing import Any, NamedTuple

from rig.assembly.buses import is_can
from rig.assembly.on_interfaces import Interfaces
from rig.assembly.registry import REGISTRY
from rig.assembly.rows import load
from rig.assembly.simulated import (
    checking_faults,
    devices_without_bus,
    emulate_line,
    emulate_nodes,
    install,
    make_plant,
)
from rig.config import Profile
from rig.hal import ConfigurationError
from rig.hal.world import BreakableWorld


class Simulation(NamedTuple):
    """An emulated rig that is open on its interfaces.

    Attributes
    ----------
    rig : drivers.sim.wall_clock.WallClockRig
        Serves it.
    ends : dict of str to CanEnd or TerminalEnd
        The simulated end of each bus, by the bus's name.
    channels : dict of str to str
        What the other program opens, by the bus's name.
    cameras : dict of str to ServedCamera
        By name; the other program reaches them over a local socket.
    left_out : tuple of str
        Devices that cannot be reached from another process.
    has_hands : bool
        Whether an acceptance test in another process reaches the rig's stop, cables and gauges.
    """

    rig: Any
    ends: dict[str, Any]
    channels: dict[str, str]
    cameras: dict[str, Any]
    left_out: tuple[str, ...]
    has_hands: bool


@contextlib.contextmanager
def open_simulation(profile: Profile, interfaces: Interfaces) -> Iterator[Simulation]:
    """Open the interfaces and put the emulated nodes of a profile on them.

    Parameters
    ----------
    profile : Profile
        Checked. Its serial lines become pseudo-terminals.
    interfaces : mapping
        Of every CAN bus, see `rig.assembly.on_interfaces.parse_interfaces`.

    Raises
    ------
    ConfigurationError
        The profile has no bus or no plant, or schedules a fault that cannot happen.
    ConnectionFailed
        An interface is missing or down.
    """
    from drivers.can import open_bus
    from drivers.sim.emulated_bus import EmulatedBus
    from drivers.sim.emulated_rig import EmulatedRig
    from drivers.sim.served_hands import serve_hands
    from drivers.sim.wall_clock import CanEnd, TerminalEnd, WallClockRig

    if not profile.buses:
        raise ConfigurationError(f"the profile {profile.name} has no bus to simulate")
    plant = make_plant(profile)
    ends: dict[str, Any] = {}
    channels: dict[str, str] = {}
    emulated: list[Any] = []
    with contextlib.ExitStack() as stack:
        for name, entry in profile.buses.items():
            nodes = emulate_nodes(profile, plant, name)
            end: Any
            if is_can(entry):
                settings = dataclasses.replace(entry.settings, **interfaces[name])
                end = CanEnd(name, open_bus(settings))
                emulated.append(EmulatedBus(name, end, nodes))
                channels[name] = settings.channel
            else:
                line = emulate_line(profile, name, nodes)
                end = TerminalEnd(name, line.port)
                emulated.append(line)
                channels[name] = end.path
            stack.callback(end.close)
            ends[name] = end
        cameras = _serve_devices(profile, plant, next(iter(channels.values())), stack)
        # The interface has a latency of its own.
        simulation = dataclasses.replace(profile.simulation, bus_latency=0.0)
        with checking_faults():
            world = EmulatedRig(
                plant,
                emulated,
                simulation,
                devices={"plant": plant},
                cameras=tuple(cameras.values()),
            )
        left_out = tuple(
            name
            for name, entry in profile.devices.items()
            if entry.bus is None and name not in cameras
        )
        hands = serve_hands(world, next(iter(channels.values())))
        for its in hands:
            stack.callback(its.close)
        served = WallClockRig(world, (*ends.values(), *cameras.values(), *hands))
        yield Simulation(served, ends, channels, cameras, left_out, bool(hands))


def reach_world(interfaces: Interfaces) -> BreakableWorld | None:
    """Return the world of `rig simulate` on interfaces as hands reach it; None: there is none.

    Parameters
    ----------
    interfaces : mapping
        Of every CAN bus; those of the simulation.
    """
    from drivers.sim.reached_hands import reach_hands

    return reach_hands(next(iter(interfaces.values()))["channel"])


def reach_devices(profile: Profile, interfaces: Interfaces) -> dict[str, Any]:
    """Return what links a profile's devices without a bus to those of `rig simulate`, by name.

    Parameters
    ----------
    profile : Profile
        What runs.
    interfaces : mapping
        Of every CAN bus; those of the simulation.
    """
    channel = next(iter(interfaces.values()))["channel"]
    links: dict[str, Any] = {}
    for name in devices_without_bus(profile):
        path = REGISTRY.driver(profile.devices[name].driver).simulation
        reach = None if path is None else load(path).reach
        if reach is not None:
            links[name] = reach(name, channel)
    return links


def _serve_devices(
    profile: Profile, plant: Any, channel: str, stack: contextlib.ExitStack
) -> dict[str, Any]:
    served: dict[str, Any] = {}
    for name in devices_without_bus(profile):
        wiring, of = install(profile, plant, name)
        if wiring.serve is not None:
            served[name] = wiring.serve(of, channel)
            stack.callback(served[name].close)
    return served
