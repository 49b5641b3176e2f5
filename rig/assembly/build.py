"""From a profile to a rig, checked before anything is opened."""

import dataclasses
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from rig.assembly.answers import check_answers
from rig.assembly.buses import bus_loads, make_bus
from rig.assembly.channels import check_channels
from rig.assembly.interface_lock import InterfaceLocks
from rig.assembly.on_interfaces import Interfaces, parse_interfaces
from rig.assembly.production import make_devices, make_mechanism
from rig.assembly.registry import REGISTRY
from rig.assembly.rig import Backend, Rig
from rig.assembly.same_geometry import check_same_geometry
from rig.assembly.signal_places import check_signal_places
from rig.assembly.watchful_clock import WatchfulClock
from rig.config import Profile, ProfileError
from rig.config.located import places_named
from rig.config.read_part import PartlyRead
from rig.hal import (
    Column,
    ConfigurationError,
    Device,
    DeviceError,
    DriverSettings,
    Mechanism,
    MonotonicClock,
    SeveralErrors,
)
from rig.hal.clock import SPIN


def check_profile(profile: Profile) -> tuple[Column, ...]:
    """Find whatever can be found wrong without opening anything.

    Returns
    -------
    tuple of Column
        What its mechanism and its devices put into each row of a log.

    Raises
    ------
    ConfigurationError
        Roles without devices, limits beyond a device's range, a bus that is too full, two
        devices with one node number: all of them at once.
    """
    found: list[ConfigurationError] = []
    for check in (
        _check_plant,
        check_same_geometry,
        check_signal_places,
        check_answers,
        _check_nodes,
        bus_loads,
    ):
        try:
            check(profile)
        except ConfigurationError as error:
            if _is_of_a_package(error):
                raise  # the checks that follow believe its answers
            found.append(error)
    if not found:
        try:
            mechanism, devices = make_unconnected(profile)
        except ConfigurationError as error:
            found.append(error)
    if found:
        try:
            _make_apart(profile)
        except ConfigurationError as error:
            found.append(error)
        raise _as_one(found, profile)
    measured = [column for device in devices.values() for column in device.log_columns]
    return (*mechanism.columns, *measured)


def with_what_else(error: ProfileError) -> ProfileError:
    """Return the errors of a profile with those that can be seen in what of it could be read.

    Parameters
    ----------
    error : ProfileError
        Of a profile.
    """
    if not isinstance(error, PartlyRead):
        return error
    part = error.part
    found: list[ConfigurationError] = []
    checks: list[Callable[[Profile], object]] = [
        _check_plant, check_same_geometry, check_signal_places, _check_nodes,
    ]  # fmt: skip
    if part.is_made:
        checks.append(partial(_make_apart, lacking=part.lacking))
    for check in checks:
        try:
            check(part.profile)
        except ConfigurationError as other:
            if not _is_of_a_package(other):
                found.append(other)
    if not found:
        return error
    texts = SeveralErrors.told_by(_as_one(found, part.profile))
    return ProfileError(error.diagnostics, texts)


def _as_one(found: Sequence[ConfigurationError], profile: Profile) -> ConfigurationError:
    """Return everything that was found as one error, each with its places."""
    for error in found:
        if _is_of_a_package(error):
            return error
    texts = dict.fromkeys(text for error in found for text in SeveralErrors.told_by(error))
    return SeveralErrors([places_named(text, profile.places) for text in texts])


def _is_of_a_package(error: ConfigurationError) -> bool:
    """Return whether it is about code, which has no place in a file."""
    return type(error) not in (ConfigurationError, SeveralErrors)


def _check_nodes(profile: Profile) -> None:
    """Refuse two devices with one number on one bus."""
    owners: dict[tuple[str | None, int], str] = {}
    clashes = []
    for name, entry in profile.devices.items():
        settings: DriverSettings = entry.settings
        for address in settings.addresses(name, entry.serial):
            owner = owners.setdefault((entry.bus, address.number), name)
            if owner != name:
                clashes.append(
                    f"devices.{owner} and devices.{name} both have number 0x{address.number:02X} "
                    f"on the bus {entry.bus}"
                )
    SeveralErrors.raise_if_any(clashes)


def _check_plant(profile: Profile) -> None:
    """Refuse the plant of another mechanism."""
    plants = REGISTRY.plants(profile.mechanism)
    if profile.plant is not None and profile.plant.model not in plants:
        raise ConfigurationError(
            f"{profile.name}: plant.model {profile.plant.model} is no plant of the "
            f"mechanism {profile.mechanism}; it has {', '.join(plants)}"
        )


def make_unconnected(
    profile: Profile,
) -> tuple[Mechanism[object, object, object, object], dict[str, Device]]:
    """Make a rig's devices and the loop's view of them; nothing is connected.

    Raises
    ------
    ConfigurationError
        Roles without devices, limits beyond a device's range.
    """
    clock = MonotonicClock()
    period = profile.loop.period
    buses = {name: make_bus(name, bus, clock, period) for name, bus in profile.buses.items()}
    try:
        devices = make_devices(profile, buses, clock)
        return make_mechanism(profile, devices), devices
    except ValueError as error:
        raise ConfigurationError(str(error)) from error


def _make_apart(profile: Profile, lacking: Sequence[str] = ()) -> None:
    """Make each device on buses of its own, and the loop's view of them.

    What is wrong with a bus keeps nobody from being told what else is wrong. Of devices that are
    `lacking` already nothing is said.
    """
    clock, period = MonotonicClock(), profile.loop.period
    devices: dict[str, Device] = {}
    found: list[str] = []
    for name, entry in profile.devices.items():
        alone = dataclasses.replace(profile, devices={name: entry})
        buses = {bus: make_bus(bus, of, clock, period) for bus, of in profile.buses.items()}
        try:
            devices |= make_devices(alone, buses, clock)
        except ConfigurationError as error:
            found.extend(SeveralErrors.told_by(error))
        except ValueError as error:  # what a driver refuses
            found.append(str(error))
    unmade = [repr(n) for n in (*lacking, *profile.devices) if n not in devices]
    try:
        make_mechanism(profile, devices)
    except ConfigurationError as error:
        told = SeveralErrors.told_by(error)
        found += [text for text in told if not any(name in text for name in unmade)]
    except ValueError as error:
        found.append(str(error))
    SeveralErrors.raise_if_any(found)


def build_rig(profile: Profile, backend: Backend, on: str | None = None, frames: Any = None) -> Rig:
    """Build a rig; nothing is opened yet.

    Parameters
    ----------
    profile : Profile
        What the rig is.
    backend : Backend
        ``sim``: devices straight on the plant. ``virtual``: production drivers, emulated
        nodes, virtual time. ``vcan``: production drivers on SocketCAN's ``vcan0``.
        ``hardware``: production drivers on what the profile names.
    on : str, optional
        Other CAN interfaces than the profile's or ``vcan0``, see
        `rig.assembly.on_interfaces.parse_interfaces`.
    frames : FrameLog, optional
        Records the CAN buses, see `rig.assembly.frame_recording.make_frame_log`.

    Raises
    ------
    ConfigurationError
        The profile cannot be run on this backend.
    DeviceError
        It must not move hardware: what that takes is not declared.
    """
    check_profile(profile)
    if backend is Backend.HARDWARE:
        check_fitness(profile)
    if backend.is_simulated:
        check_channels(profile)
        from rig.assembly.simulated import build_sim, build_virtual

        return build_sim(profile) if backend is Backend.SIM else build_virtual(profile, frames)
    clock = MonotonicClock(spin=SPIN if profile.loop.spin else 0.0)
    if on is None and backend is Backend.VCAN:
        on = backend.value
    others = parse_interfaces(on, profile) if on is not None else {}
    waits = WatchfulClock(clock)
    buses = {
        name: make_bus(name, bus, waits, profile.loop.period, others.get(name), frames=frames)
        for name, bus in profile.buses.items()
    }
    locks = InterfaceLocks()
    links = None
    if backend is Backend.VCAN and others:
        from rig.assembly.simulation_process import reach_devices

        links = reach_devices(profile, others)
    devices = make_devices(profile, buses, waits, links)
    return Rig(
        profile,
        backend,
        clock=clock,
        buses=buses,
        devices=devices,
        mechanism=make_mechanism(profile, devices),
        take=partial(_take_interfaces, profile, others, locks),
        release=locks.give_back,
        waits=waits,
    )


def check_fitness(profile: Profile) -> None:
    """Refuse hardware for a profile that does not declare what it takes.

    Raises
    ------
    DeviceError
        With what its mechanism lacks.
    """
    mechanism = REGISTRY.load("mechanism", profile.mechanism)
    reason = mechanism.unfit(profile.mechanism_settings)
    if reason is not None:
        raise DeviceError(profile.name, reason)


def _take_interfaces(profile: Profile, others: Interfaces, locks: InterfaceLocks) -> None:
    for name, entry in profile.buses.items():
        locks.take(name, dataclasses.replace(entry.settings, **others.get(name, {})))
