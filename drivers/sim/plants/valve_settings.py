"""Parameters of a proportional spool valve with a pressure sensor at its chamber.

Sources of the numbers as in `drivers.sim.plants.settings`: V verified, C catalogue, E estimate.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Self

from annotated_types import Ge, Gt, Interval, Le, Lt, Unit

from drivers.sim.plants.settings import (
    CarriageSettings,
    CylinderPlantSettings,
    TubedActuatorSettings,
    carriage_mass,
)


@dataclass(frozen=True, slots=True)
class SpoolSettings:
    """One 5/3 valve of which one chamber port is used, Festo MPYE-5-1/8-LF size.

    Parameters
    ----------
    dac_bits : int
        Resolution of the converter that drives it over the whole signal, bits. E.
    bandwidth : float
        Natural frequency of the spool's own position loop, rad/s: about 100 Hz. C.
    bandwidth_spread : float
        Bound of the relative deviation of a unit's bandwidth. E.
    damping : float
        Its damping ratio. E.
    slew : float
        Greatest speed of the spool, strokes from the middle per second: 5 ms through the whole
        stroke. C.
    hysteresis : float
        Width of the spool's hysteresis loop over half of its stroke. C: 0.4 % at most.
    dead_time : float
        From a new signal to the first motion of the spool, s. E: the valve's electronics.
    dead_time_spread : float
        Bound of the relative deviation of a unit's dead time. E.
    overlap : float
        Opening at which the spool uncovers a port. C: 1 to 2 %.
    overlap_spread : float
        Bound of the relative deviation of each of a unit's two overlaps. E.
    zero : float
        Bound of the opening at which a unit's spool is in the middle; drawn per unit. E.
    conductance_in, conductance_out : float
        Sonic conductance of the ports at full stroke, m³/(s Pa). C: 350 L/min size, throttled to
        0.4 dm³/(s bar). E.
    conductance_spread : float
        Bound of the relative deviation of each of a unit's two conductances. E.
    progression : float
        How much flatter than its mean the characteristic begins: the flow's area over the stroke
        beyond the overlap s is ``s (1 - progression (1 - s))``. E.
    progression_spread : float
        Bound of the deviation of each of a unit's two progressions. E.
    critical_ratio : float
        Critical pressure ratio b of both ports. C: 0.2 to 0.4.
    critical_ratio_spread : float
        Bound of the deviation of each of a unit's two critical ratios. E.
    leakage : float
        Leak past the lands of a spool in the middle, both ways, over the conductances. E.
    full_scale : float
        Range of the pressure sensor, Pa gauge. C.
    monitor_noise : float
        Noise of the sensor, rms over full scale: 100 Pa. E.
    monitor_time : float
        Time constant of the sensor with its filter, s. E.
    monitor_error : float
        Bound of the sensor's error of gain, and of its offset over full scale; drawn per unit. C.
    supply_pressure : float
        Pa gauge. C.
    supply_time : float
        Time constant with which the supply line fills and empties, s. E.
    supply_volume : float
        Of the line before the valves, m³, which sags as they draw from it; 0: it never sags. E.
    """

    dac_bits: Annotated[int, Interval(ge=4, le=24)] = 12
    bandwidth: Annotated[float, Unit("rad/s"), Gt(0), Le(5000)] = 628.0
    bandwidth_spread: Annotated[float, Ge(0), Lt(0.5)] = 0.1
    damping: Annotated[float, Gt(0), Le(3)] = 0.7
    slew: Annotated[float, Unit("1/s"), Gt(0)] = 400.0
    hysteresis: Annotated[float, Ge(0), Lt(0.1)] = 0.003
    dead_time: Annotated[float, Unit("s"), Ge(0), Le(0.02)] = 1e-3
    dead_time_spread: Annotated[float, Ge(0), Le(0.5)] = 0.1
    overlap: Annotated[float, Ge(0), Lt(0.2)] = 0.015
    overlap_spread: Annotated[float, Ge(0), Lt(1)] = 0.4
    zero: Annotated[float, Ge(0), Lt(0.1)] = 0.01
    conductance_in: Annotated[float, Unit("m^3/(s Pa)"), Ge(0)] = 4.0e-9
    conductance_out: Annotated[float, Unit("m^3/(s Pa)"), Ge(0)] = 3.6e-9
    conductance_spread: Annotated[float, Ge(0), Lt(0.5)] = 0.1
    progression: Annotated[float, Ge(0), Lt(1)] = 0.25
    progression_spread: Annotated[float, Ge(0), Lt(0.5)] = 0.15
    critical_ratio: Annotated[float, Ge(0), Lt(1)] = 0.3
    critical_ratio_spread: Annotated[float, Ge(0), Lt(0.3)] = 0.08
    leakage: Annotated[float, Ge(0), Lt(0.1)] = 0.003
    full_scale: Annotated[float, Unit("Pa"), Gt(0)] = 0.5e6
    monitor_noise: Annotated[float, Ge(0), Lt(0.1)] = 0.0002
    monitor_time: Annotated[float, Unit("s"), Ge(0), Le(0.1)] = 0.5e-3
    monitor_error: Annotated[float, Ge(0), Le(0.05)] = 0.0025
    supply_pressure: Annotated[float, Unit("Pa"), Ge(0)] = 0.7e6
    supply_time: Annotated[float, Unit("s"), Gt(0)] = 0.02
    supply_volume: Annotated[float, Unit("m^3"), Ge(0)] = 2e-4


@dataclass(frozen=True, slots=True)
class ValvePairSettings(CylinderPlantSettings):
    """One antagonistic pair with a proportional valve and a sensor at each chamber.

    Parameters
    ----------
    valve : SpoolSettings
        The valves, the same for every channel.
    carriage : CarriageSettings
        What the pair moves.
    """

    encoder_noise: Annotated[float, Unit("m"), Ge(0), Le(1e-3)] = 1e-6
    cylinder: TubedActuatorSettings = field(default_factory=TubedActuatorSettings)
    valve: SpoolSettings = field(default_factory=SpoolSettings)
    carriage: CarriageSettings = field(default_factory=CarriageSettings)

    @property
    def feed(self) -> SpoolSettings:
        """See `CylinderPlantSettings.feed`."""
        return self.valve

    def believed(self, told: Mapping[str, float]) -> Self:
        """See `CylinderPlantSettings.believed`; besides, what is told of spools and carriage.

        Parameters
        ----------
        told : mapping
            ``spool_bandwidth``, ``spool_dead_time`` and ``mass``, SI, among others.
        """
        # By its name: a dataclass with slots is made anew, which an empty super() does not see.
        like = CylinderPlantSettings.believed(self, told)
        mass = carriage_mass(told["mass"], self.cylinder)
        return replace(
            like,
            valve=believed_spool(self.valve, told),
            carriage=replace(self.carriage, mass=mass),
        )


def believed_spool(valve: SpoolSettings, told: Mapping[str, float]) -> SpoolSettings:
    """Return a valve that is as the laws are told.

    Parameters
    ----------
    told : mapping
        ``spool_bandwidth`` and ``spool_dead_time``, SI, among others.
    """
    return replace(
        valve,
        bandwidth=told["spool_bandwidth"],
        dead_time=max(told["spool_dead_time"], 0.0),
    )


def stroke_steps(settings: SpoolSettings) -> float:
    """Return how many steps the converter has over the whole signal."""
    return math.ldexp(1.0, settings.dac_bits) - 1.0
