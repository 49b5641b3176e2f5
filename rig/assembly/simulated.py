"""Rigs without hardware: the only place outside of `drivers.sim` that knows the simulation."""

import contextlib
import dataclasses
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from rig.assembly.buses import is_can, make_bus
from rig.assembly.contract_check import check_offers, make
from rig.assembly.production import make_devices, make_mechanism
from rig.assembly.registry import REGISTRY
from rig.assembly.rig import Backend, Rig
from rig.assembly.rows import load
from rig.assembly.true_columns import true_meaning
from rig.assembly.watchful_clock import WatchfulClock
from rig.config import Perturbation, Profile
from rig.hal import ConfigurationError, Plant
from rig.hal.columns import Column
from rig.hal.fits import is_ours
from rig.hal.plant import LentPlant


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
        return _plant_of(profile.plant.model, plant, settings, seed, *extra)
    from drivers.sim.perturbation import draw, perturb_geometry, perturb_plant

    draws = draw(_bounds(profile), seed)
    extra = () if geometry is None else (perturb_geometry(geometry, draws),)
    made = _plant_of(profile.plant.model, plant, perturb_plant(settings, draws), seed, *extra)
    if any(draws.leaks):
        made.set_leaks(draws.leaks[: len(made.channel_names)])
    return made


def _plant_of(model: str, plant: type, *arguments: object) -> Any:
    try:
        made = make(f"the plant {model}", plant, *arguments)
    except ValueError as error:  # its settings are valid, and do not suit this geometry
        if not is_ours(plant):
            raise
        raise ConfigurationError(f"the plant {model}: {error}") from error
    check_offers(f"the plant {model}", made, Plant)
    return made


def _bounds(profile: Profile) -> dict[str, float]:
    return dataclasses.asdict(profile.simulation.perturbation)


def friction_drawn(profile: Profile) -> float:
    """Return the share of its friction that a simulated unit has besides, by its perturbation."""
    from drivers.sim.perturbation import draw

    return draw(_bounds(profile), profile.simulation.seed).friction


def _truth_columns(plant: Any) -> tuple[Column, ...]:
    return tuple(
        Column(f"truth.{name}", unit, true_meaning(name, unit))
        for name, unit in plant.truth_columns
    )


def install(profile: Profile, plant: Any, name: str) -> tuple[Any, Any]:
    """Return a device's `drivers.sim.wiring` object, and the device as it is built in.

    Raises
    ------
    ConfigurationError
        There is no simulated device for its driver, or the plant has no channel for it.
    """
    from drivers.sim.perturbation import draw
    from drivers.sim.wiring import Installed, plant_channels

    entry = profile.devices[name]
    bounds, seed = _bounds(profile), profile.simulation.seed
    row = REGISTRY.driver(entry.driver)
    path = row.simulation
    if path is None and entry.bus is not None:
        path = REGISTRY.protocol(profile.buses[entry.bus].protocol).nodes
    if path is None:
        raise ConfigurationError(
            f"{name}: there is no simulated device for {entry.driver}; name one in the driver's "
            "row (DriverParts.simulation)"
        )
    wiring = load(path)
    of = Installed(
        name,
        entry.settings,
        plant,
        nominal=entry.nominal,
        description=entry.eds,
        serial=entry.serial,
        seed=seed,
        bounds=bounds,
    )
    if not row.on_bus:
        return wiring, of
    mechanism = REGISTRY.load("mechanism", profile.mechanism)
    wired = mechanism.wiring(profile.mechanism_settings)
    own = entry.settings.channel_names()
    channels = plant_channels(name, wired, plant.channel_names, own, needed=wiring.needs_channels)
    port = plant
    if wiring.perturb is not None and profile.simulation.perturbation != Perturbation():
        port = wiring.perturb(plant, draw(bounds, seed))
    return wiring, dataclasses.replace(of, plant=port, channels=channels)


def lend_plant(
    profile: Profile,
    told: Mapping[str, float],
    seed: int,
    substep: float | None = None,
    noisier: float = 1.0,
) -> LentPlant:
    """Lend a plant that is as the laws are told, for a loop that runs compiled as a whole.

    Parameters
    ----------
    profile : Profile
        Its plant says what a model does not tell: hysteresis, tubes, noise.
    told : mapping
        Numbers of the mechanism's model, SI (`rig.hal.PhysicsSettings.believed`).
    seed : int
        Of what units are off, and of the devices' noise.
    substep : float, optional
        Other than the plant's own, s.
    noisier : float
        Times the noise of the plant's encoders.

    Raises
    ------
    ConfigurationError
        The profile has no plant, or its plant lends nothing.
    """
    from drivers.sim.direct.chambers import SimulatedChambers
    from drivers.sim.direct.encoders import SimulatedEncoder

    devices = build_sim(profile).devices.values()
    rods = [device.resolution for device in devices if isinstance(device, SimulatedEncoder)]
    chambers = [device.resolution for device in devices if isinstance(device, SimulatedChambers)]
    entry = profile.plant
    if entry is None or not REGISTRY.lends_kernel(entry.model) or not rods or not chambers:
        model = "without a plant" if entry is None else f"with the plant {entry.model}"
        raise ConfigurationError(f"the profile {profile.name}, {model}, has no kernel to lend")
    settings = entry.settings.believed(told)
    changes = {} if substep is None else {"substep": substep}
    if hasattr(settings, "encoder_noise"):
        changes["encoder_noise"] = noisier * settings.encoder_noise
    settings = dataclasses.replace(settings, **changes)
    believed = dataclasses.replace(entry, settings=settings)
    simulation = dataclasses.replace(profile.simulation, seed=seed)
    plant = make_plant(dataclasses.replace(profile, plant=believed, simulation=simulation))
    kernel, memory = plant.lend(profile.loop.period, max(rods), max(chambers), seed)
    return LentPlant(kernel, memory, len(plant.channel_names))


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
    from drivers.sim.camera.wiring import true_camera

    _, of = install(profile, make_plant(profile), name)
    camera = true_camera(of)
    return BoardRenderer(camera.scene, camera.optics, columns, rows, square, of.seed).render


def check_plant_faults(profile: Profile) -> None:
    """Refuse faults that are scheduled for the plant and that it does not know.

    Raises
    ------
    ConfigurationError
        With what it knows.
    """
    of_plant = [fault for fault in profile.simulation.faults if fault.device == "plant"]
    if profile.plant is None or not of_plant:
        return
    from drivers.sim.faults import FaultSchedule

    with checking_faults():
        FaultSchedule(of_plant, {"plant": make_plant(profile)})


def build_sim(profile: Profile, plant: Any = None) -> Rig:
    """Build a rig whose devices stand straight on the plant, the profile's own or a given one."""
    from drivers.sim.clock import SimClock
    from drivers.sim.faults import FaultSchedule, FaultyWorld

    plant = make_plant(profile) if plant is None else plant
    devices: dict[str, Any] = {}
    clock = SimClock(plant)
    for name, entry in profile.devices.items():
        wiring, of = install(profile, plant, name)
        if entry.bus is not None and entry.calibration is not None and wiring.correct is not None:
            of = dataclasses.replace(of, plant=wiring.correct(of))
        devices[name] = wiring.simulate(of, clock)
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
    """Make the emulated nodes of every device on a bus, with ports to the plant."""
    nodes: list[Any] = []
    for name, entry in profile.devices.items():
        if entry.bus == bus:
            wiring, of = install(profile, plant, name)
            # Wired as the maker says: a calibration is the driver's knowledge of it.
            nodes += wiring.emulate(of)
    return nodes


def emulate_line(profile: Profile, bus: str, nodes: list[Any]) -> Any:
    """Make the simulated end of a bus that is no CAN.

    Raises
    ------
    ConfigurationError
        Its protocol has none.
    """
    entry = profile.buses[bus]
    path = REGISTRY.protocol(entry.protocol).line
    if path is None:
        raise ConfigurationError(
            f"bus {bus}: there is no simulated {entry.protocol} bus; name one in the protocol's "
            "row (ProtocolParts.line)"
        )
    return load(path)(bus, entry.settings, nodes)


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
            line = emulate_line(profile, bus, nodes)
            emulated.append(line)
            ports[bus] = partial(_port_of, line)
    links = {}
    for name in devices_without_bus(profile):
        wiring, of = install(profile, plant, name)
        links[name] = wiring.emulate(of)
    with checking_faults():
        world = EmulatedRig(
            plant,
            emulated,
            profile.simulation,
            devices={"plant": plant},
            cameras=tuple(links.values()),
        )
    clock = SimClock(world)
    waits, period = WatchfulClock(clock), profile.loop.period
    buses = {
        name: make_bus(name, bus, waits, period, None, ports[name], frames)
        for name, bus in profile.buses.items()
    }
    devices = make_devices(profile, buses, waits, links)

    return Rig(
        profile,
        Backend.VIRTUAL,
        clock=clock,
        buses=buses,
        devices=devices,
        mechanism=make_mechanism(profile, devices),
        truth_columns=_truth_columns(plant),
        truth=plant.truth,
        waits=waits,
    )


def devices_without_bus(profile: Profile) -> list[str]:
    """Return the devices that hang on no bus, by name."""
    return [
        name for name, entry in profile.devices.items() if not REGISTRY.driver(entry.driver).on_bus
    ]


def _port_of(line: Any) -> Any:
    return line.port


@contextlib.contextmanager
def checking_faults() -> Iterator[None]:
    """Turn a scheduled fault that cannot happen into a configuration error."""
    try:
        yield
    except ValueError as error:
        raise ConfigurationError(str(error)) from error
