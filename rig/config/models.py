"""What a profile and an experiment say, as plain data in SI.

Nothing heavy is imported here, so that any module may name these types.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from annotated_types import Ge, Interval, MinLen, Unit


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
    """

    rate: Annotated[float, Unit("Hz"), Interval(ge=1, le=5000)]
    priority: Annotated[int, Interval(ge=0, le=99)] = 80
    cpu: Annotated[int, Interval(ge=0, le=1023)] | None = None
    spin: bool = False
    max_missed: Annotated[int, Interval(ge=1, le=1000)] = 5

    @property
    def period(self) -> float:
        """Time from one cycle to the next, s."""
        return 1.0 / self.rate


@dataclass(frozen=True, slots=True)
class FaultSpec:
    """Something that goes wrong in simulation.

    Parameters
    ----------
    at : float
        When, seconds after the start.
    device : str
        The device or bus that it befalls.
    fault : str
        What; the emulated device knows the names.
    value : float, optional
        How much, in SI, where the fault takes a value.
    """

    at: Annotated[float, Unit("s"), Ge(0)]
    device: str
    fault: Annotated[str, MinLen(1)]
    value: float | None = None


@dataclass(frozen=True, slots=True)
class SimulationSettings:
    """What the simulated world has that the plant has not.

    Parameters
    ----------
    seed : int
        Of everything random.
    bus_latency : float
        From a sent frame to the node that receives it, s.
    frame_loss : float
        Share of frames that get lost, 0 … 1.
    faults : tuple of FaultSpec
        What goes wrong, and when.
    """

    seed: Annotated[int, Interval(ge=0, lt=2**32)] = 0
    bus_latency: Annotated[float, Unit("s"), Interval(ge=0, le=0.1)] = 3e-4
    frame_loss: Annotated[float, Unit("1"), Interval(ge=0, le=1)] = 0.0
    faults: tuple[FaultSpec, ...] = ()


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a calibration came from.

    Parameters
    ----------
    date : str
        When it was taken, ISO 8601.
    operator : str
        Who took it.
    serial : int, optional
        Serial number of the device that was calibrated.
    samples : int, optional
        How many measurements it rests on.
    residual_rms, residual_max : float, optional
        What the fit leaves, in `unit`.
    unit : str, optional
        SI unit of the residuals; taken from them where they are written with one.
    parent : str, optional
        The calibration that this one replaced.
    valid_until : str, optional
        When it should be taken again, ISO 8601.
    software : str, optional
        Version of the program that computed it.
    conditions : dict of str to str
        Anything else worth knowing: temperature, rig, remarks.
    """

    date: str
    operator: Annotated[str, MinLen(1)]
    serial: Annotated[int, Ge(0)] | None = None
    samples: Annotated[int, Ge(1)] | None = None
    residual_rms: Annotated[float, Ge(0)] | None = None
    residual_max: Annotated[float, Ge(0)] | None = None
    unit: str | None = None
    parent: str | None = None
    valid_until: str | None = None
    software: str | None = None
    conditions: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Calibration:
    """A calibration that was laid over a device's settings.

    Parameters
    ----------
    file : str
        Where it was read, from the folder of the configurations on.
    provenance : Provenance
        Where it came from.
    """

    file: str
    provenance: Provenance


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
    """

    driver: str
    bus: str | None
    serial: int | None
    settings: Any
    calibration: Calibration | None = None
    eds: Path | None = None


@dataclass(frozen=True, slots=True)
class BusEntry:
    """A bus: the protocol that is spoken on it, and the settings that go with it."""

    protocol: str
    settings: Any


@dataclass(frozen=True, slots=True)
class PlantEntry:
    """The simulated physics: a plant's name and its settings."""

    model: str
    settings: Any


@dataclass(frozen=True, slots=True)
class Profile:
    """What a rig is.

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
    """

    name: str
    description: str
    mechanism: str
    mechanism_settings: Any
    loop: LoopSettings
    buses: dict[str, BusEntry]
    devices: dict[str, DeviceEntry]
    controllers: dict[str, Any]
    plant: PlantEntry | None
    simulation: SimulationSettings
    files: tuple[Path, ...] = field(default=(), compare=False)


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
    settings: Any


@dataclass(frozen=True, slots=True)
class Experiment:
    """What to do with a rig.

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
