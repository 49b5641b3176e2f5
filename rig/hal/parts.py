"""What a package offers to the program: one row for each mechanism, driver or bus protocol.

A row names things by their path, ``"module:name"``, which is imported when the thing is used: a
row itself costs nothing, so `rig list` stays fast. Another package offers its rows by entry
points in the groups ``rig.mechanisms``, ``rig.drivers``, ``rig.protocols`` and ``rig.additions``;
the entry point's name is the name that profiles use. Nothing of a package is imported that no
profile names: additions stand in its list ``additions``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

Path = str
"""``"module:name"``."""


@dataclass(frozen=True, slots=True)
class PlantModel:
    """A plant and its settings.

    Parameters
    ----------
    settings : Path
        Dataclass of a profile's section ``plant``, a `rig.hal.PhysicsSettings`.
    plant : Path
        The class, a `rig.hal.Plant`.
    hazards : Path, optional
        ``hazards(settings)``, which makes `rig.hal.hazards.Hazard`s of the mechanism's settings;
        without it `rig faults` cannot judge the rig.
    is_restorable : bool
        It is a `rig.hal.RestorablePlant`; without that nothing is known of frozen setpoints.
    lends_kernel : bool
        It is a `rig.hal.plant.LendingPlant`; without that `rig tune` cannot work with it.
    channels : tuple of str
        Its `rig.hal.Plant.channel_names`, by which `rig check` knows a device that is mounted on
        none; without it only a run says so.
    """

    settings: Path
    plant: Path
    hazards: Path | None = None
    is_restorable: bool = False
    lends_kernel: bool = False
    channels: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Additions:
    """Things that may be added to a mechanism, also by another package than the mechanism's own.

    Parameters
    ----------
    mechanism : str
        The mechanism's name.
    controllers : mapping of str to Path
        Classes of `rig.hal.Law`, by the name that profiles use.
    references : mapping of str to Path
        Settings dataclasses, by the name that experiments use; no two mechanisms may share one.
    plants : mapping of str to PlantModel
        By the name that profiles use.
    measures : tuple of Path
        Mappings of names to `rig.experiment.measure.Measure`.
    facts : tuple of Path
        Mappings of names to `rig.hal.motion.FactKind`: what motions know of themselves beforehand.
    figures : tuple of Path
        Mappings of names to `rig.report.figure.FigureKind`.
    comparisons : tuple of Path
        `rig.report.comparison.Comparison`; the first that suits all runs draws them.
    procedures : tuple of Path
        Classes of `rig.calibration.procedure.Procedure`, in the order in which they build on
        each other.
    reported : tuple of str
        Names of measures that every run reports, whether or not its experiment asks for them.
    """

    mechanism: str
    controllers: Mapping[str, Path] = field(default_factory=dict)
    references: Mapping[str, Path] = field(default_factory=dict)
    plants: Mapping[str, PlantModel] = field(default_factory=dict)
    measures: tuple[Path, ...] = ()
    facts: tuple[Path, ...] = ()
    figures: tuple[Path, ...] = ()
    comparisons: tuple[Path, ...] = ()
    procedures: tuple[Path, ...] = ()
    reported: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class MechanismParts(Additions):
    """Everything of one mechanism.

    Parameters
    ----------
    settings : Path
        Dataclass of the profile's section with the mechanism's name.
    view : Path
        The class that the loop runs, a `rig.hal.Mechanism`.
    bench : Path, optional
        A `rig.hal.bench.TuningBench`, on which `rig tune` tries gains; without it nothing is tuned.
    measured_loop : Path, optional
        ``measured_loop(run, law)``, the `rig.hal.measured_loop.MeasuredLoop` that a law closes,
        from a run of the experiment that is called after the mechanism, as ``cylinder-margins``;
        without it `rig margins` cannot measure one.
    commissioning : Path, optional
        ``steps()``, the `rig.commissioning.step.AcceptanceStep`s of its acceptance test in their
        order; without it `rig commission` cannot test the rig.
    scene : Path, optional
        A `rig.hal.scene.Scene`, which `rig watch` shows; without it the page has its scope alone.
    drawings : mapping of str to Path
        `rig.hal.drawn_profile.Draw`s, with which `rig new rig` makes profiles, by the format.
    """

    settings: Path
    view: Path
    bench: Path | None = None
    measured_loop: Path | None = None
    commissioning: Path | None = None
    scene: Path | None = None
    drawings: Mapping[str, Path] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class DriverParts:
    """Everything of one driver.

    Parameters
    ----------
    settings : Path
        Dataclass of a device's section, a `rig.hal.DriverSettings`.
    device : Path
        The driver: ``Class(name, settings, bus, serial=)`` on a bus, and
        ``Class(name, settings, clock, serial=, link=)`` of a device that hangs on none. The name
        is the profile's, the serial number the one that the device must report (None: any), and
        the link what stands between device and program (None: its own).
    on_bus : bool
        Whether it hangs on a bus of the profile.
    simulation : Path, optional
        Its simulated forms, a `drivers.sim.wiring.Wiring` or, without a bus, a `LinkWiring`.
        Without one, a device is emulated as its bus's protocol can (`ProtocolParts.nodes`).
    """

    settings: Path
    device: Path
    on_bus: bool = True
    simulation: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ProtocolParts:
    """Everything of what may be spoken on a bus.

    Parameters
    ----------
    settings : Path
        Dataclass of a bus's section, a `rig.hal.BusSettings`.
    bus : Path
        ``Class(name, settings, open, clock, period)``, a `rig.hal.CyclicBus`.
    open : Path
        ``open(settings)``, which opens the interface.
    load : Path
        ``load(name, settings, devices, rate)``, which computes the load, and refuses too much.
    decoder : Path, optional
        ``decoder(settings, devices)``, a `rig.hal.frames.Decoder` of the bus's frames; `devices`
        are names, settings and paths of description files (or None).
    discovery : Path, optional
        ``discovery(bus, clock, numbers)``, the `rig.hal.frames.Found` who answer.
    nodes : Path, optional
        The `drivers.sim.wiring.Wiring` of devices whose drivers bring no simulation.
    line : Path, optional
        ``line(name, settings, nodes)``, the simulated end of a bus that is no CAN, which is a
        `drivers.sim.emulated_rig.SimulatedBus` with the host's end as its ``port``.
    is_can : bool
        Whether it runs on a CAN interface.
    """

    settings: Path
    bus: Path
    open: Path
    load: Path
    decoder: Path | None = None
    discovery: Path | None = None
    nodes: Path | None = None
    line: Path | None = None
    is_can: bool = True
