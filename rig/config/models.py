"""Profiles, experiments and calibrations as plain data in SI.

Nothing heavy is imported here, so that any module may name these types.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, TypeAlias

from annotated_types import Ge, Interval, MinLen, Unit

from rig.config.located import Plain
from rig.config.names import rig_argument
from rig.config.simulation_models import SimulationSettings

Settings: TypeAlias = Any
"""Settings of which only the driver or mechanism that they belong to knows what they hold."""


@dataclass(frozen=True, slots=True)
class LoopSettings:
    """The cycle.

    Parameters
    ----------
    rate : float
        Cycles per second, Hz.
    priority : int
        SCHED_FIFO priority where permitted; 0 leaves the scheduling as it is.
    cpu : int, optional
        The processor that the loop is pinned to.
    spin : bool
        Busy-wait for the last part of every period: less jitter for a whole processor.
    max_missed : int
        This many missed deadlines one after another are a fault.
    safe_within : float
        For how long at most the safe setpoints are repeated until the devices' own readings say
        that they are safe; else the run ends with a fault. Chambers vent in some 0.3 s.
    longest_motion : float
        A motion that takes longer is refused, s: one that is asked for by mistake would fill
        memory while it is planned, or run until the disk is full.
    small_margin : str, optional
        Why hardware may run a loop that is nearer to instability than `rig check` asks for: a
        sensitivity above 2, or stable by friction only. None: it is refused.
    """

    rate: Annotated[float, Unit("Hz"), Interval(ge=1, le=5000)]
    priority: Annotated[int, Interval(ge=0, le=99)] = 80
    cpu: Annotated[int, Interval(ge=0, le=1023)] | None = None
    spin: bool = False
    max_missed: Annotated[int, Interval(ge=1, le=1000)] = 5
    safe_within: Annotated[float, Unit("s"), Interval(ge=0, le=10)] = 1.0
    longest_motion: Annotated[float, Unit("s"), Interval(gt=0, le=604800)] = 1800.0
    small_margin: str | None = None

    @property
    def period(self) -> float:
        """Time from one cycle to the next, s."""
        return 1.0 / self.rate


@dataclass(frozen=True, slots=True)
class Provenance:
    """The origin of a calibration.

    Parameters
    ----------
    date : str
        When it was taken, ISO 8601.
    operator : str
        Who took it.
    backend : str, optional
        Where it was measured: ``hardware``, or what simulated it. Of several values the one that
        was not measured on hardware, if there is one.
    seed : int, optional
        Of the simulation.
    serial : int, optional
        Serial number of the device that was calibrated.
    host : str, optional
        The computer that the rig was on when it was measured on hardware.
    profile : str, optional
        The profile's file, as `rig.config.ownership.owner_label` has it.
    samples : int, optional
        How many measurements it rests on.
    blocks : int, optional
        How many independent repetitions of the measurement it rests on.
    residual_rms, residual_max : float, optional
        What the fit leaves, in `unit`.
    residual_bound : float, optional
        The rms above which the fit is not to be used, in `unit`.
    unit : str, optional
        SI unit of the residuals; taken from them where they are written with one.
    parent : str, optional
        The calibration that this one replaced.
    valid_until : str, optional
        When it should be taken again, ISO 8601.
    software : str, optional
        Version of the program that computed it.
    procedure : str, optional
        The procedure that was followed.
    log, log_sha256 : str, optional
        Path and SHA-256 of the raw log that it was computed from.
    conditions : dict of str to str
        Anything else worth knowing: temperature, rig, remarks.
    basis : dict of str to dict
        What the profile said of the rig meanwhile, by the procedures that measured, as texts with
        units by dotted names; empty in files of before it was kept.
    """

    date: str
    operator: Annotated[str, MinLen(1)]
    backend: str | None = None
    seed: int | None = None
    serial: Annotated[int, Ge(0)] | None = None
    host: str | None = None
    profile: str | None = None
    samples: Annotated[int, Ge(1)] | None = None
    blocks: Annotated[int, Ge(1)] | None = None
    residual_rms: Annotated[float, Ge(0)] | None = None
    residual_max: Annotated[float, Ge(0)] | None = None
    residual_bound: Annotated[float, Ge(0)] | None = None
    unit: str | None = None
    parent: str | None = None
    valid_until: str | None = None
    software: str | None = None
    procedure: str | None = None
    log: str | None = None
    log_sha256: str | None = None
    conditions: dict[str, str] = field(default_factory=dict)
    basis: dict[str, dict[str, str]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Calibration:
    """A calibration that was laid over a device's settings.

    Parameters
    ----------
    file : str
        Where it was read, from the folder of the configurations on.
    provenance : Provenance
        Where it came from.
    replaced : dict
        What the settings said before, in the same words as the calibration's values.
    deviations : dict of str to float
        Standard deviation of each quantity that was measured, in its SI unit.
    """

    file: str
    provenance: Provenance
    replaced: Plain = field(default_factory=dict)
    deviations: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class DeviceEntry:
    """One device of a rig.

    Parameters
    ----------
    driver : str
        Its driver's name.
    bus : str or None
        The bus of the profile that it hangs on.
    serial : int or None
        The serial number that it must report.
    settings : object
        The driver's settings, calibration included.
    calibration : Calibration or None
        What was laid over the settings.
    eds : Path or None
        The file with the device's objects that its settings name.
    uncalibrated : object
        The settings without the calibration: what the maker and the profile say of it.
    """

    driver: str
    bus: str | None
    serial: int | None
    settings: Settings
    calibration: Calibration | None = None
    eds: Path | None = None
    uncalibrated: object = None

    @property
    def nominal(self) -> Settings:
        """The settings as if the device had never been calibrated."""
        return self.settings if self.uncalibrated is None else self.uncalibrated


@dataclass(frozen=True, slots=True)
class BusEntry:
    """A bus: the protocol that is spoken on it, and the settings that go with it."""

    protocol: str
    settings: Settings


@dataclass(frozen=True, slots=True)
class PlantEntry:
    """The simulated physics: a plant's name and its settings."""

    model: str
    settings: Settings


@dataclass(frozen=True, slots=True)
class Profile:
    """A rig.

    Parameters
    ----------
    name, description : str
        For people, and for the folder of the rig's calibrations.
    mechanism : str
        The mechanism's name; in the file also the key of its settings.
    mechanism_settings : object
        The mechanism's settings.
    loop : LoopSettings
        The cycle.
    buses, devices, controllers : dict
        By name: buses, devices, controller settings.
    plant : PlantEntry or None
        The simulated physics.
    simulation : SimulationSettings
        The simulated world around it.
    files : tuple of Path
        Everything that was read for it, the profile itself first; no part of its value.
    calibration : Calibration or None
        What was laid over the mechanism's settings.
    uncalibrated : object
        The mechanism's settings without it.
    tunings : dict
        What `rig tune` has laid over controllers' settings, by name; no part of its value.
    foreign : dict
        Calibrations that lie under the profile's name and are another rig's: not in force, by
        device, mechanism or ``controllers.LAW``; no part of its value.
    calibrated_bases : dict
        The rig that this one extends and that is calibrated where this one is not, by device,
        mechanism or ``controllers.LAW``; no part of its value.
    places : dict
        Where each key stands, ``file:line:column``, by its dotted name; no part of its value.
    additions : tuple of str
        What other packages add to the mechanism, by the names of their entry points: nothing of
        theirs is imported that a profile does not name.
    unitless : tuple of str
        A sentence for each number without a unit where people write one; no part of its value.
    """

    name: str
    description: str
    mechanism: str
    mechanism_settings: Settings
    loop: LoopSettings
    buses: dict[str, BusEntry]
    devices: dict[str, DeviceEntry]
    controllers: dict[str, Settings]
    plant: PlantEntry | None
    simulation: SimulationSettings
    files: tuple[Path, ...] = field(default=(), compare=False)
    calibration: Calibration | None = None
    uncalibrated: object = None
    tunings: dict[str, Calibration] = field(default_factory=dict, compare=False)
    foreign: dict[str, Calibration] = field(default_factory=dict, compare=False)
    calibrated_bases: dict[str, str] = field(default_factory=dict, compare=False)
    places: dict[str, str] = field(default_factory=dict, compare=False, repr=False)
    additions: tuple[str, ...] = ()
    unitless: tuple[str, ...] = field(default=(), compare=False, repr=False)

    @property
    def nominal_settings(self) -> Settings:
        """The mechanism's settings as if it had never been calibrated."""
        return self.mechanism_settings if self.uncalibrated is None else self.uncalibrated

    @property
    def argument(self) -> str:
        """What a command line names it by: `name` alone is found in ``rigs`` folders only."""
        return rig_argument(self.name, self.files)

    @property
    def calibrations(self) -> dict[str, Calibration]:
        """What is in force, by device, by the mechanism's name, or by ``controllers.LAW``."""
        found = {name: entry.calibration for name, entry in self.devices.items()}
        found[self.mechanism] = self.calibration
        found.update({f"controllers.{law}": used for law, used in self.tunings.items()})
        return {name: used for name, used in found.items() if used is not None}


@dataclass(frozen=True, slots=True)
class MetricSpec:
    """A number that an experiment asks for.

    Parameters
    ----------
    measure : str, optional
        The measure's name; default: the name of the metric.
    segments : str
        Pattern of the names of the reference's segments that it is taken over.
    max, min : float, optional
        Acceptance bounds, SI.
    unit : str, optional
        SI unit of the bounds, taken from them where they are written with one: whoever
        knows the measure can check it.
    when : dict
        Settings of the rig or the experiment, by their dotted names, and the values with which
        the metric is asked for; with others it is left out.
    """

    measure: Annotated[str, MinLen(1)] | None = None
    segments: Annotated[str, MinLen(1)] = "*"
    max: float | None = None
    min: float | None = None
    unit: str | None = None
    when: dict[str, float | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.max is not None and self.min is not None and self.min > self.max:
            raise ValueError(f"min ({self.min:g}) is above max ({self.max:g}): nothing passes.")


@dataclass(frozen=True, slots=True)
class ReferenceEntry:
    """The desired motion: a reference's name and its settings."""

    kind: str
    settings: object


@dataclass(frozen=True, slots=True)
class Experiment:
    """A task for a rig.

    Parameters
    ----------
    name, description : str
        For people, and for the names of run folders.
    rig : str
        The profile's name.
    controller : str
        The controller that drives it.
    reference : ReferenceEntry
        The desired motion.
    approach : float
        Time to go from where the rig is to where the reference starts, s.
    metrics : dict of str to MetricSpec
        What is measured afterwards.
    figures : tuple of str
        Names of the figures to draw.
    files : tuple of Path
        Everything that was read for it; no part of its value.
    places : dict
        Where each key stands, ``file:line:column``, by its dotted name; no part of its value.
    unitless : tuple of str
        A sentence for each quantity of the reference that has no unit; no part of its value.
    """

    name: str
    description: str
    rig: str
    controller: str
    reference: ReferenceEntry
    approach: float
    metrics: dict[str, MetricSpec]
    figures: tuple[str, ...]
    files: tuple[Path, ...] = field(default=(), compare=False)
    places: dict[str, str] = field(default_factory=dict, compare=False, repr=False)
    unitless: tuple[str, ...] = field(default=(), compare=False, repr=False)
