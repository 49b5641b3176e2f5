"""From a profile to a rig: the only module that knows concrete drivers and controllers.

Names map to ``"module:class"``; a class is imported when a profile uses it. Other packages
add theirs through the entry-point groups ``rig.drivers``, ``rig.controllers``,
``rig.mechanisms``, ``rig.plants`` and ``rig.references``; no import has a side effect.
"""

import importlib
import itertools
import os
from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from importlib.metadata import entry_points
from typing import Any, NamedTuple

from rig.config import Profile
from rig.config.registry import Kind
from rig.hal import Clock, ConfigurationError, CyclicBus, Device, MonotonicClock
from rig.runtime.columns import Column


class _Class(NamedTuple):
    """Where a class and its settings are; settings apart where the class is slow to import."""

    path: str
    settings: str | None = None


_TABLE: dict[Kind, dict[str, _Class]] = {
    "bus": {
        "can": _Class("drivers.canopen.bus:CanopenBus", "drivers.canopen.settings:CanBusSettings")
    },
    "driver": {
        "cia401": _Class(
            "drivers.regulators.cia401:Cia401Regulators",
            "drivers.regulators.cia401_settings:Cia401Settings",
        ),
        "cia406": _Class(
            "drivers.encoders.cia406:Cia406Encoder",
            "drivers.encoders.cia406_settings:Cia406Settings",
        ),
    },
    "controller": {
        "pid": _Class("controllers.cylinder.pid:Pid"),
        "pid-friction": _Class("controllers.cylinder.pid_friction:PidFriction"),
        "cascade": _Class("controllers.cylinder.cascade:Cascade"),
        "super-twisting": _Class("controllers.cylinder.super_twisting:SuperTwisting"),
    },
    "mechanism": {
        "cylinder": _Class(
            "rig.mechanisms.cylinder:AntagonisticPair",
            "rig.mechanisms.cylinder_settings:CylinderSettings",
        ),
    },
    "plant": {
        "antagonistic-pair": _Class(
            "drivers.sim.plants.antagonistic_pair:AntagonisticPairPlant",
            "drivers.sim.plants.settings:PlantSettings",
        ),
    },
    "reference": {
        "sine": _Class("rig.experiment.references:Sine", "rig.experiment.references:Sine"),
        "staircase": _Class(
            "rig.experiment.references:Staircase", "rig.experiment.references:Staircase"
        ),
        "step": _Class("rig.experiment.references:Step", "rig.experiment.references:Step"),
        "ramp": _Class("rig.experiment.references:Ramp", "rig.experiment.references:Ramp"),
    },
}


def _load(path: str) -> Any:
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)


class InstalledClasses:
    """The registry of everything a profile or experiment may name; see `Registry`."""

    def names(self, kind: Kind) -> tuple[str, ...]:
        """Return every name of a kind, sorted."""
        others = {point.name for point in entry_points(group=f"rig.{kind}s")}
        return tuple(sorted(others | set(_TABLE[kind])))

    def settings(self, kind: Kind, name: str) -> type[Any]:
        """Return the settings dataclass of a name; KeyError if there is none."""
        known = _TABLE[kind].get(name)
        if known is not None and known.settings is not None:
            settings: type[Any] = _load(known.settings)
            return settings
        found: type[Any] = self.load(kind, name).Settings
        return found

    def load(self, kind: Kind, name: str) -> Any:
        """Return the class behind a name; KeyError if there is none."""
        known = _TABLE[kind].get(name)
        if known is not None:
            return _load(known.path)
        for point in entry_points(group=f"rig.{kind}s", name=name):
            return point.load()
        raise KeyError(name)


REGISTRY = InstalledClasses()


class Backend(StrEnum):
    """What a run runs on."""

    SIM = "sim"
    VIRTUAL = "virtual"
    VCAN = "vcan"
    HARDWARE = "hardware"

    @property
    def is_simulated(self) -> bool:
        """Whether time is virtual and the plant is in this process."""
        return self in (Backend.SIM, Backend.VIRTUAL)


class Rig:
    """Buses, devices and mechanism of one profile on one backend; a context manager.

    Entering opens the buses and connects every device; leaving makes everything safe and
    closes it, whatever happened in between.

    Parameters
    ----------
    profile : Profile
        What it was built from.
    backend : Backend
        What it runs on.
    clock : Clock
        Virtual or real.
    buses, devices : mapping
        By name.
    mechanism : Mechanism
        The loop's view of it.
    truth_columns : sequence of Column
        In simulation: what `truth` returns.
    truth : callable
        In simulation: the plant's true values.
    """

    def __init__(
        self,
        profile: Profile,
        backend: Backend,
        *,
        clock: Clock,
        buses: Mapping[str, CyclicBus],
        devices: Mapping[str, Device],
        mechanism: Any,
        truth_columns: Sequence[Column] = (),
        truth: Callable[[], tuple[float, ...]] = tuple,
        release: Callable[[], None] = lambda: None,
    ) -> None:
        self.profile = profile
        self.backend = backend
        self.clock = clock
        self.buses = buses
        self.devices = devices
        self.mechanism = mechanism
        self.truth_columns = tuple(truth_columns)
        self.truth = truth
        self._release = release

    def make_controller(self, name: str) -> Any:
        """Return a controller of the profile, for this mechanism.

        Raises
        ------
        ConfigurationError
            The profile has no settings for it.
        """
        controllers = self.profile.controllers
        if name not in controllers:
            raise ConfigurationError(
                f"the profile {self.profile.name} has no controller {name!r}; "
                f"it has {', '.join(controllers)}"
            )
        controller = REGISTRY.load("controller", name)(
            controllers[name], self.mechanism.model, self.profile.loop.period
        )
        self.mechanism.controller = controller
        return controller

    def __enter__(self) -> "Rig":
        try:
            for bus in self.buses.values():
                bus.open()
            for device in self.devices.values():
                device.connect()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def arm(self) -> None:
        """Make every device follow its setpoints, which are the safe ones until the loop runs."""
        for device in self.devices.values():
            device.arm()

    def close(self) -> None:
        """Make safe and release everything; idempotent."""
        for device in self.devices.values():
            device.make_safe()
        for bus in self.buses.values():
            bus.make_safe()
        for device in self.devices.values():
            device.close()
        for bus in self.buses.values():
            bus.close()
        self._release()

    def statistics(self) -> dict[str, dict[str, float]]:
        """Return the counters of every bus, for the manifest."""
        return {name: bus.statistics() for name, bus in self.buses.items()}


def bus_loads(profile: Profile) -> dict[str, Any]:
    """Return the worst-case load of each bus of a profile, `drivers.canopen.load.BusLoad`.

    Raises
    ------
    ConfigurationError
        A bus has more to carry than its `max_load`.
    """
    from drivers.canopen.load import check_bus_load

    return {
        name: check_bus_load(name, settings, _on_bus(profile, name), profile.loop.rate)
        for name, settings in profile.buses.items()
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
    buses = {name: _make_bus(name, settings, clock) for name, settings in profile.buses.items()}
    try:
        _make_mechanism(profile, _make_devices(profile, buses))
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
    if backend is Backend.SIM:
        return _build_sim(profile)
    if backend is Backend.VIRTUAL:
        return _build_virtual(profile)
    clock = MonotonicClock(spin=200e-6 if profile.loop.spin else 0.0)
    on = {"interface": "socketcan", "channel": "vcan0"} if backend is Backend.VCAN else {}
    buses = {name: _make_bus(name, bus, clock, on) for name, bus in profile.buses.items()}
    devices = _make_devices(profile, buses)
    return Rig(
        profile,
        backend,
        clock=clock,
        buses=buses,
        devices=devices,
        mechanism=_make_mechanism(profile, devices),
    )


def _make_bus(
    name: str, settings: Any, clock: Clock, on: Mapping[str, Any] | None = None
) -> CyclicBus:
    import dataclasses

    from drivers.can import open_bus

    settings = dataclasses.replace(settings, **(on or {}))
    bus: CyclicBus = REGISTRY.load("bus", "can")(name, settings, lambda: open_bus(settings), clock)
    return bus


def _make_devices(profile: Profile, buses: Mapping[str, CyclicBus]) -> dict[str, Device]:
    devices: dict[str, Device] = {}
    for name, entry in profile.devices.items():
        if entry.bus is None:
            raise ConfigurationError(f"{name}: the driver {entry.driver} needs a bus")
        driver = REGISTRY.load("driver", entry.driver)
        devices[name] = driver(name, entry.settings, buses[entry.bus], serial=entry.serial)
    return devices


def _make_mechanism(profile: Profile, devices: Mapping[str, Device]) -> Any:
    mechanism = REGISTRY.load("mechanism", profile.mechanism)
    return mechanism.assemble(profile.mechanism_settings, devices, profile.loop.period)


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


def _build_sim(profile: Profile) -> Rig:
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
        mechanism=_make_mechanism(profile, devices),
        truth_columns=_truth_columns(plant),
        truth=plant.truth,
    )


_virtual_channels = itertools.count()


def _build_virtual(profile: Profile) -> Rig:
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
    buses = {name: _make_bus(name, bus, clock, on[name]) for name, bus in profile.buses.items()}
    devices = _make_devices(profile, buses)

    def release() -> None:
        for end in ends:
            end.shutdown()

    return Rig(
        profile,
        Backend.VIRTUAL,
        clock=clock,
        buses=buses,
        devices=devices,
        mechanism=_make_mechanism(profile, devices),
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


def _on_bus(profile: Profile, bus: str) -> list[tuple[str, Any]]:
    return [(name, entry.settings) for name, entry in profile.devices.items() if entry.bus == bus]
