"""Parameters of an electro-pneumatic regulator and of the tube to its chamber.

Each comes twice. The plain one is ideal where a controller's model is: it has no dead time, no
tube, and its monitor is exact but for noise. The `Real` one has all of it. Sources of the numbers
as in `drivers.sim.plants.settings`.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Interval, Le, Lt, Unit


@dataclass(frozen=True, slots=True)
class RegulatorSettings:
    """One electro-pneumatic regulator, SMC ITV1030 size.

    Parameters
    ----------
    full_scale : float
        Greatest set pressure, Pa gauge. C.
    dac_bits : int
        Resolution of the converter that drives it, bits. E.
    hysteresis : float
        Width of the hysteresis loop over full scale. C.
    linearity : float
        Bound of the bow of its static characteristic over full scale; drawn per unit. C.
    bandwidth : float
        Natural frequency of the pilot stage, rad/s: 97 ms to 90 %. C: about 0.1 s.
    bandwidth_spread : float
        Bound of the relative deviation of a unit's bandwidth. E.
    damping : float
        Damping ratio of the pilot stage. E.
    pilot_rate : float
        Greatest rate of the pilot pressure, Pa/s. E.
    dead_band : float
        Half width of the main valve's overlap over full scale. V: 0.1 % (Festo VPPE), the
        catalogue's sensitivity of 0.2 % in all (C).
    proportional_band : float
        Pressure error that opens the main valve fully, over full scale. E.
    valve_time : float
        Time constant of the main valve, s. E.
    conductance_in, conductance_out : float
        Sonic conductance from the supply and to the atmosphere, m³/(s Pa). 0.30 dm³/(s bar)
        gives the 200 L/min ANR of the catalogue (V) at its 1.0 MPa supply.
    critical_ratio : float
        Critical pressure ratio b of both. E.
    supply_pressure : float
        Pa gauge. C.
    supply_time : float
        Time constant with which the supply line fills and empties, s. E.
    monitor_noise : float
        Noise of the pressure monitor, rms over full scale. E.
    monitor_time : float
        Time constant of the monitor's filter, s. E.
    monitor_error : float
        Bound of the monitor's error of gain, and of its offset over full scale; drawn per unit. E.
    dead_time : float
        From a setpoint to the first motion of the pilot stage, s. E: electronics, solenoids.
    dead_time_spread : float
        Bound of the relative deviation of a unit's dead time. E.
    sampling : float
        Period with which the regulator samples its setpoint, s; 0: it sees it at once. E.
    repeatability : float
        Bound of the error over full scale that is drawn anew whenever the setpoint has turned
        round by more than the hysteresis. C: 0.5 %.
    least : float
        Least pressure that it regulates to while it has supply, Pa gauge. V: 5 kPa.
    pilot : str
        ``linear``: a pilot stage of second order. ``switched``: a feed and an exhaust valve that
        are opened for a part of each period, as the error of the outlet's pressure asks.
    pilot_period : float
        Period of the switched pilot, s. E.
    pilot_filter : float
        Time constant of the outlet's pressure as the switched pilot sees it, s. E.
    supply_volume : float
        Of the line before the regulators, m³, which sags as they draw from it; 0: it never
        sags. E.
    """

    full_scale: Annotated[float, Unit("Pa"), Gt(0)] = 0.5e6
    dac_bits: Annotated[int, Interval(ge=4, le=24)] = 12
    hysteresis: Annotated[float, Ge(0), Lt(0.1)] = 0.005
    linearity: Annotated[float, Ge(0), Lt(0.1)] = 0.01
    bandwidth: Annotated[float, Unit("rad/s"), Gt(0), Le(500)] = 40.0
    bandwidth_spread: Annotated[float, Ge(0), Lt(0.5)] = 0.05
    damping: Annotated[float, Gt(0), Le(3)] = 1.0
    pilot_rate: Annotated[float, Unit("Pa/s"), Gt(0)] = 7e6
    dead_band: Annotated[float, Ge(0), Lt(0.1)] = 0.001
    proportional_band: Annotated[float, Gt(0), Le(1)] = 0.04
    valve_time: Annotated[float, Unit("s"), Ge(5e-4)] = 3e-3
    conductance_in: Annotated[float, Unit("m^3/(s Pa)"), Ge(0)] = 3.0e-9
    conductance_out: Annotated[float, Unit("m^3/(s Pa)"), Ge(0)] = 2.0e-9
    critical_ratio: Annotated[float, Ge(0), Lt(1)] = 0.3
    supply_pressure: Annotated[float, Unit("Pa"), Ge(0)] = 0.7e6
    supply_time: Annotated[float, Unit("s"), Gt(0)] = 0.02
    monitor_noise: Annotated[float, Ge(0), Lt(0.1)] = 0.0005
    monitor_time: Annotated[float, Unit("s"), Ge(0), Le(0.1)] = 0.0
    monitor_error: Annotated[float, Ge(0), Le(0.05)] = 0.0
    dead_time: Annotated[float, Unit("s"), Ge(0), Le(0.05)] = 0.0
    dead_time_spread: Annotated[float, Ge(0), Le(0.5)] = 0.1
    sampling: Annotated[float, Unit("s"), Ge(0), Le(0.02)] = 0.0
    repeatability: Annotated[float, Ge(0), Le(0.05)] = 0.0
    least: Annotated[float, Unit("Pa"), Ge(0), Le(50e3)] = 0.0
    pilot: Literal["linear", "switched"] = "linear"
    pilot_period: Annotated[float, Unit("s"), Ge(5e-4), Le(0.05)] = 5e-3
    pilot_filter: Annotated[float, Unit("s"), Ge(0), Le(0.05)] = 3e-3
    supply_volume: Annotated[float, Unit("m^3"), Ge(0)] = 0.0


@dataclass(frozen=True, slots=True)
class RealRegulatorSettings(RegulatorSettings):
    """A regulator as a catalogue and its mounting leave it."""

    monitor_time: Annotated[float, Unit("s"), Ge(0), Le(0.1)] = 5e-3
    monitor_error: Annotated[float, Ge(0), Le(0.05)] = 0.005
    dead_time: Annotated[float, Unit("s"), Ge(0), Le(0.05)] = 5e-3
    sampling: Annotated[float, Unit("s"), Ge(0), Le(0.02)] = 1e-3
    repeatability: Annotated[float, Ge(0), Le(0.05)] = 0.005
    least: Annotated[float, Unit("Pa"), Ge(0), Le(50e3)] = 5e3
    supply_volume: Annotated[float, Unit("m^3"), Ge(0)] = 2e-4


@dataclass(frozen=True, slots=True)
class TubeSettings:
    """The tube from a regulator, with its monitor, to the chamber.

    Parameters
    ----------
    length, bore : float
        m; of no length, the monitor sees the chamber.
    outlet : float
        Volume between the regulator's valve and the tube, m³, where the monitor is. E.
    """

    length: Annotated[float, Unit("m"), Ge(0), Le(10)] = 0.0
    bore: Annotated[float, Unit("m"), Ge(1e-3), Le(0.02)] = 2.5e-3
    outlet: Annotated[float, Unit("m^3"), Gt(0)] = 2e-6

    def __post_init__(self) -> None:
        if 0.0 < self.length < _SHORTEST:
            raise ValueError(
                f"length ({self.length:g} m) is neither 0 nor a tube: {_SHORTEST:g} m or more is."
            )


@dataclass(frozen=True, slots=True)
class RealTubeSettings(TubeSettings):
    """A tube of the usual length."""

    length: Annotated[float, Unit("m"), Ge(0), Le(10)] = 1.0


_SHORTEST = 0.1
"""A shorter tube takes finer steps than a plant has, m."""
