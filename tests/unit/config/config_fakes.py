"""A registry of made-up devices and a profile that uses all of it."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal

from annotated_types import Ge, Gt, Interval, Le, MinLen, Unit

import rig.hal


@dataclass(frozen=True, slots=True)
class BusSettings(rig.hal.BusSettings):
    interface: str
    channel: str
    bitrate: Annotated[int, Unit("bit/s"), Interval(ge=10_000, le=1_000_000)] = 1_000_000
    heartbeat: Annotated[float, Unit("s"), Gt(0)] = 0.1


@dataclass(frozen=True, slots=True)
class ChannelSettings:
    number: Annotated[int, Interval(ge=1, le=8)]
    full_scale: Annotated[float, Unit("Pa"), Gt(0)]
    setpoint: tuple[int, int] = (0x6411, 1)


@dataclass(frozen=True, slots=True)
class ValveSettings:
    """A valve module.

    Parameters
    ----------
    node : int
        Its number on the bus.
    channels : dict of str to ChannelSettings
        By name.
    """

    node: Annotated[int, Interval(ge=1, le=127)]
    channels: Annotated[dict[str, ChannelSettings], MinLen(1)]
    watchdog: Annotated[float, Unit("s"), Gt(0)] | None = None
    scaling: Literal["linear", "bipolar"] = "linear"


@dataclass(frozen=True, slots=True)
class EncoderSettings:
    node: Annotated[int, Interval(ge=1, le=127)]
    resolution: Annotated[float, Unit("m"), Gt(0)] = 1e-6
    offset: Annotated[float, Unit("m")] = 0.0
    stroke: Annotated[float, Unit("m"), Gt(0)] = 0.06
    inverted: bool = False


@dataclass(frozen=True, slots=True)
class Friction:
    coulomb: Annotated[float, Unit("N"), Ge(0)]
    breakaway: Annotated[float, Unit("N"), Ge(0)]
    viscous: Annotated[float, Unit("N s/m"), Ge(0)] = 25.0

    def __post_init__(self) -> None:
        if self.breakaway < self.coulomb:
            raise ValueError("breakaway is below coulomb.")


@dataclass(frozen=True, slots=True)
class CylinderSettings:
    regulators: str
    encoder: str
    bore: Annotated[float, Unit("m"), Gt(0)]
    area: Annotated[float, Unit("m^2"), Gt(0)]
    friction: Friction
    position: Annotated[tuple[float, float], Unit("m")]
    gains: tuple[Annotated[float, Ge(0)], ...] = ()

    def __post_init__(self) -> None:
        if not self.position[0] < self.position[1]:
            raise ValueError("position: the lower limit is not below the upper one.")


@dataclass(frozen=True, slots=True)
class PidSettings:
    proportional: Annotated[float, Unit("Pa/m"), Ge(0)] = 2e7
    integral: Annotated[float, Ge(0)] = 0.0
    dither: Annotated[float, Unit("Hz"), Gt(0)] | None = None


@dataclass(frozen=True, slots=True)
class CascadeSettings:
    stiffness: Annotated[float, Unit("N/m"), Gt(0), Le(1e9)] = 1.5e5
    poles: tuple[Annotated[float, Unit("rad/s")], ...] = (40.0, 60.0)


@dataclass(frozen=True, slots=True)
class PlantSettings:
    seals: Literal["standard", "low-speed"] = "standard"
    conductance: Annotated[float, Unit("m^3/(s Pa)"), Gt(0)] = 3e-9
    friction: Friction = field(default_factory=lambda: Friction(3.0, 4.5))


@dataclass(frozen=True, slots=True)
class Tone:
    frequency: Annotated[float, Unit("Hz"), Gt(0)]
    periods: Annotated[int, Ge(1)] = 3


@dataclass(frozen=True, slots=True)
class SineSettings:
    amplitude: Annotated[float, Unit("m"), Gt(0)]
    tones: Annotated[tuple[Tone, ...], MinLen(1)]


@dataclass(frozen=True, slots=True)
class StepSettings:
    height: Annotated[float, Unit("m")]


class FakeRegistry:
    """What assembly would know."""

    TABLE: ClassVar = {
        "bus": {"canopen": BusSettings},
        "driver": {"valve-module": ValveSettings, "linear-encoder": EncoderSettings},
        "controller": {"pid": PidSettings, "cascade": CascadeSettings},
        "mechanism": {"cylinder": CylinderSettings, "joint": Friction},
        "plant": {"antagonistic-pair": PlantSettings},
        "reference": {"sine": SineSettings, "step": StepSettings},
    }

    def names(self, kind):
        return tuple(sorted(self.TABLE[kind]))

    imported = names

    def admit(self, additions):
        raise KeyError(additions)

    def unnamed(self):
        return ()

    def settings(self, kind, name):
        return self.TABLE[kind][name]

    def references(self, mechanism):
        return self.names("reference") if mechanism == "cylinder" else ()


PROFILE = """\
# One antagonistic pair on a bench.
name: bench
description: "The pair on the bench: left table"
mechanism: cylinder
loop: {rate: 500 Hz, priority: 70, cpu: 1}

buses:
  can0:
    interface: virtual
    channel: bench
    bitrate: 1 Mbit/s

devices:
  valves:
    driver: valve-module
    bus: can0
    node: 0x10
    watchdog: 20 ms
    channels:
      agonist: {number: 1, full_scale: 0.5 MPa}
      antagonist: {number: 2, full_scale: 5e5, setpoint: [0x6411, 2]}
  encoder:
    driver: linear-encoder
    bus: can0
    serial: 4711
    node: 33
    stroke: 60 mm

cylinder:
  regulators: valves
  encoder: encoder
  bore: 16 mm
  area: 181.5 mm^2
  position: [-9 mm, 9 mm]
  gains: [1, 2.5, 1e-3]
  friction:
    coulomb: 3 N
    breakaway: 4.5 N
    viscous: 25 N s/m

controllers:
  pid: {proportional: 2e7, dither: 40 Hz}
  cascade:
    stiffness: 1.5e5 N/m

plant:
  model: antagonistic-pair
  seals: low-speed
  conductance: 0.03 dm^3/(s bar)

simulation:
  seed: 7
  frame_loss: 25 %
  faults:
    - {at: 500 ms, device: encoder, fault: frozen}
    - {at: 2, device: can0, fault: loss, value: 0.5}
"""

EXPERIMENT = """\
description: Sines of three frequencies
rig: bench
controller: cascade
approach: 1500 ms
reference:
  kind: sine
  amplitude: 8 mm
  tones:
    - {frequency: 0.1 Hz}
    - {frequency: 0.2 Hz, periods: 5}
metrics:
  tracking_rms: {segments: "0.2 Hz", max: 0.15 mm}
  hold: {measure: hold_rms, min: 0, max: 30 µm}
  settling: {}
figures: [position, pressures]
"""

CALIBRATION = """\
values:
  offset: 0.12 mm
  resolution: 0.9995 µm
provenance:
  date: 2026-11-21
  operator: A. N. Other
  serial: 4711
  samples: 400
  residual_rms: 3 µm
  residual_max: 9 µm
"""
