"""A profile's plant and emulated nodes on real interfaces, for a rig in another process."""

import contextlib
import dataclasses
from collections.abc import Iterator
from typing import Any, NamedTuple

from rig.assembly.buses import is_can
from rig.assembly.on_interfaces import Interfaces
from rig.assembly.simulated import checking_faults, emulate_nodes, make_plant, reality_of
from rig.config import Profile
from rig.hal import ConfigurationError


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
    """

    rig: Any
    ends: dict[str, Any]
    channels: dict[str, str]
    cameras: dict[str, Any]
    left_out: tuple[str, ...]


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
    from drivers.sim.dynamixel.line import EmulatedSerialBus
    from drivers.sim.emulated_bus import EmulatedBus
    from drivers.sim.emulated_rig import EmulatedRig
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
                line = EmulatedSerialBus(name, entry.settings.baudrate, nodes)
                end = TerminalEnd(name, line.port)
                emulated.append(line)
                channels[name] = end.path
            stack.callback(end.close)
            ends[name] = end
        cameras = _serve_cameras(profile, plant, channels, stack)
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
        served = WallClockRig(world, (*ends.values(), *cameras.values()))
        yield Simulation(served, ends, channels, cameras, left_out)


def reach_cameras(profile: Profile, interfaces: Interfaces) -> dict[str, Any]:
    """Return what links a profile's cameras to those of `rig simulate`, by the device's name.

    Parameters
    ----------
    profile : Profile
        What runs.
    interfaces : mapping
        Of every CAN bus; those of the simulation.
    """
    from drivers.sim.camera.wiring import reach_marker_camera

    channel = next(iter(interfaces.values()))["channel"]
    return {name: reach_marker_camera(name, channel) for name in _cameras(profile)}


def _cameras(profile: Profile) -> list[str]:
    return [name for name, entry in profile.devices.items() if entry.driver == "marker-camera"]


def _serve_cameras(
    profile: Profile, plant: Any, channels: dict[str, str], stack: contextlib.ExitStack
) -> dict[str, Any]:
    from drivers.sim.camera.wiring import serve_marker_camera

    cameras: dict[str, Any] = {}
    for name in _cameras(profile):
        entry = profile.devices[name]
        camera = serve_marker_camera(
            name,
            entry.settings,
            plant,
            profile.simulation.seed,
            next(iter(channels.values())),
            serial=entry.serial,
            **reality_of(profile, name, plant),
        )
        stack.callback(camera.close)
        cameras[name] = camera
    return cameras
