"""From a profile to a rig, checked before anything is opened."""

from typing import Any

from rig.assembly.parts import make_bus, make_devices, make_mechanism
from rig.assembly.rig import Backend, Rig
from rig.config import Profile
from rig.hal import ConfigurationError, MonotonicClock


def bus_loads(profile: Profile) -> dict[str, Any]:
    """Return the worst-case load of each bus of a profile, `drivers.canopen.load.BusLoad`.

    Raises
    ------
    ConfigurationError
        A bus has more to carry than its `max_load`.
    """
    from drivers.canopen.load import check_bus_load

    return {
        name: check_bus_load(name, bus.settings, _on_bus(profile, name), profile.loop.rate)
        for name, bus in profile.buses.items()
    }


def check_profile(profile: Profile) -> None:
    """Find whatever can be found wrong without opening anything.

    Raises
    ------
    ConfigurationError
        Roles without devices, limits beyond a device's range, a bus that is too full, two
        devices with one node number.
    """
    bus_loads(profile)
    clock = MonotonicClock()
    buses = {name: make_bus(name, bus, clock) for name, bus in profile.buses.items()}
    try:
        make_mechanism(profile, make_devices(profile, buses, clock))
    except ValueError as error:
        raise ConfigurationError(str(error)) from error


def build_rig(profile: Profile, backend: Backend) -> Rig:
    """Build a rig; nothing is opened yet.

    Parameters
    ----------
    profile : Profile
        What the rig is.
    backend : Backend
        ``sim``: devices straight on the plant. ``virtual``: production drivers, emulated
        nodes, virtual time. ``vcan``: production drivers on SocketCAN's ``vcan0``.
        ``hardware``: production drivers on what the profile names.

    Raises
    ------
    ConfigurationError
        The profile cannot be run on this backend.
    """
    check_profile(profile)
    if backend.is_simulated:
        from rig.assembly.simulated import build_sim, build_virtual

        return (build_sim if backend is Backend.SIM else build_virtual)(profile)
    clock = MonotonicClock(spin=200e-6 if profile.loop.spin else 0.0)
    on = {"interface": "socketcan", "channel": "vcan0"} if backend is Backend.VCAN else {}
    buses = {name: make_bus(name, bus, clock, on) for name, bus in profile.buses.items()}
    devices = make_devices(profile, buses, clock)
    return Rig(
        profile,
        backend,
        clock=clock,
        buses=buses,
        devices=devices,
        mechanism=make_mechanism(profile, devices),
    )


def _on_bus(profile: Profile, bus: str) -> list[tuple[str, Any]]:
    return [(name, entry.settings) for name, entry in profile.devices.items() if entry.bus == bus]
