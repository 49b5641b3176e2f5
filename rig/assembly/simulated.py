"""Rigs without hardware: the only place outside of `drivers.sim` that knows the simulation."""

import contextlib
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from rig.assembly.buses import is_can, make_bus
from rig.assembly.production import make_devices, make_mechanism
from rig.assembly.registry import REGISTRY, load
from rig.assembly.rig import Backend, Rig
from rig.config import DeviceEntry, Perturbation, Profile
from rig.hal import ConfigurationError
from rig.hal.columns import Column


def make_plant(profile: Profile) -> Any:
    """Make the physics of a profile.

    Raises
    ------
    ConfigurationError
        The profile has none.
    """
    if profile.plant is None:
        raise ConfigurationError(
            f"the profile {profile.name} has no plant, so it cannot be simulated"
        )
    plant = REGISTRY.load("plant", profile.plant.model)
    settings, seed = profile.plant.settings, profile.simulation.seed
    # A plant does its own algebra on the geometry that the controllers are told of; what was
    # calibrated since is the controllers' knowledge and changes nothing in it.
    view = REGISTRY.load("mechanism", profile.mechanism)
    geometry = view.geometry_of(profile.nominal_settings)
    if profile.simulation.perturbation == Perturbation():
        extra = () if geometry is None else (geometry,)
        return plant(settings, seed, *extra)
    from drivers.sim.perturbation import PerturbedPlant, draw, perturb_geometry, perturb_plant

    draws = draw(profile.simulation.perturbation, seed)
    extra = () if geometry is None else (perturb_geometry(geometry, draws),)
    return PerturbedPlant(plant(perturb_plant(settings, draws), seed, *extra), draws)


def _truth_columns(plant: Any) -> tuple[Column, ...]:
    return tuple(
        Column(f"truth.{name}", unit, "true value in the simulated plant")
        for name, unit in plant.truth_columns
    )


def _simulation(name: str, entry: DeviceEntry) -> Any:
    path = REGISTRY.driver(entry.driver).simulation
    if path is None:
        raise ConfigurationError(f"{name}: there is no simulated device for {entry.driver}")
    return load(path)


def _wire(profile: Profile, plant: Any, name: str) -> tuple[Any, tuple[int, ...]]:
    from drivers.sim.wiring import plant_channels

    entry = profile.devices[name]
    mechanism = REGISTRY.load("mechanism", profile.mechanism)
    wired = mechanism.wiring(profile.mechanism_settings)
    own = tuple(getattr(entry.settings, "channels", getattr(entry.settings, "joints", ())))
    return _simulation(name, entry), plant_channels(name, wired, plant, own)


def reality_of(profile: Profile, name: str, plant: Any) -> dict[str, Any]:
    """Return what is true of a simulated device without a bus, whatever its driver believes."""
    entry, simulation = profile.devices[name], profile.simulation
    real: dict[str, Any] = _simulation(name, entry).reality(
        entry.nominal, plant, simulation.perturbation, simulation.seed
    )
    return real


def board_renderer(
    profile: Profile, name: str, columns: int, rows: int, square: float
) -> Callable[..., Any]:
    """Return what makes images of a chessboard as a simulated camera sees it.

    Parameters
    ----------
    profile : Profile
        The rig.
    name : str
        The camera.
    columns, rows : int
        Squares of the board.
    square : float
        Side of one, m.
    """
    from drivers.sim.camera.board import BoardRenderer

    real = reality_of(profile, name, make_plant(profile))
    seed = profile.simulation.seed
    return BoardRenderer(real["scene"], real["optics"], columns, rows, square, seed).render


def build_sim(profile: Profile) -> Rig:
    """Build a rig whose devices stand straight on the plant."""
    from drivers.sim.clock import SimClock
    from drivers.sim.faults import FaultSchedule, FaultyWorld

    plant = make_plant(profile)
    devices: dict[str, Any] = {}
    clock = SimClock(plant)
    for name, entry in profile.devices.items():
        if not REGISTRY.driver(entry.driver).on_bus:
            devices[name] = _simulation(name, entry).simulate(
                name, entry.settings, plant, clock, profile.simulation.seed, serial=entry.serial,
                **reality_of(profile, name, plant),
            )  # fmt: skip
            continue
        wiring, channels = _wire(profile, plant, name)
        port = plant
        if entry.calibration is not None and wiring.correct is not None:
            port = wiring.correct(entry.nominal, entry.settings, plant, channels)
        devices[name] = wiring.simulate(name, entry.settings, port, channels, clock)
    if profile.simulation.faults:
        targets = {**devices, "plant": plant}
        with checking_faults():
            schedule = FaultSchedule(profile.simulation.faults, targets)
        clock.world = FaultyWorld(plant, schedule)
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


def emulate_nodes(profile: Profile, plant: Any, bus: str) -> list[Any]:
    """Make the emulated node of every device on a bus, with ports to the plant."""
    nodes: list[Any] = []
    for name, entry in profile.devices.items():
        if entry.bus == bus:
            wiring, channels = _wire(profile, plant, name)
            # Wired as the maker says: a calibration is the driver's knowledge of it.
            made = wiring.emulate(name, entry.nominal, plant, channels, entry.serial or 0)
            nodes += made if isinstance(made, tuple) else (made,)
    return nodes


def build_virtual(profile: Profile, frames: Any = None) -> Rig:
    """Build a rig with production drivers against emulated nodes, in virtual time.

    Parameters
    ----------
    profile : Profile
        What the rig is.
    frames : FrameLog, optional
        Records the CAN buses.
    """
    from drivers.sim.can_line import CanLine
    from drivers.sim.clock import SimClock
    from drivers.sim.dynamixel.line import EmulatedSerialBus
    from drivers.sim.emulated_bus import EmulatedBus
    from drivers.sim.emulated_rig import EmulatedRig

    plant = make_plant(profile)
    emulated: list[Any] = []
    ports: dict[str, Callable[[], Any]] = {}
    for bus, spoken in profile.buses.items():
        nodes = emulate_nodes(profile, plant, bus)
        if is_can(spoken):
            wire = CanLine(bus)
            emulated.append(EmulatedBus(bus, wire.nodes_end, nodes))
            ports[bus] = wire.open
        else:
            line = EmulatedSerialBus(bus, spoken.settings.baudrate, nodes)
            emulated.append(line)
            ports[bus] = partial(getattr, line, "port")
    links = {
        name: _simulation(name, entry).emulate(
            name,
            entry.settings,
            plant,
            profile.simulation.seed,
            serial=entry.serial,
            **reality_of(profile, name, plant),
        )
        for name, entry in profile.devices.items()
        if not REGISTRY.driver(entry.driver).on_bus
    }
    with checking_faults():
        world = EmulatedRig(
            plant,
            emulated,
            profile.simulation,
            devices={"plant": plant},
            cameras=tuple(links.values()),
        )
    clock = SimClock(world)
    period = profile.loop.period
    buses = {
        name: make_bus(name, bus, clock, period, None, ports[name], frames)
        for name, bus in profile.buses.items()
    }
    devices = make_devices(profile, buses, clock, links)

    return Rig(
        profile,
        Backend.VIRTUAL,
        clock=clock,
        buses=buses,
        devices=devices,
        mechanism=make_mechanism(profile, devices),
        truth_columns=_truth_columns(plant),
        truth=plant.truth,
    )


@contextlib.contextmanager
def checking_faults() -> Iterator[None]:
    """Turn a scheduled fault that cannot happen into a configuration error."""
    try:
        yield
    except ValueError as error:
        raise ConfigurationError(str(error)) from error
