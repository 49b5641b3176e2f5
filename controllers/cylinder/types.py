"""The values that pass through the loop of one antagonistic pair.

Sign convention: a cylinder's pressurised chamber is on the rod side, so pressure pulls the
wire in. The pair's position is half the difference of the rod extensions, positive when the
agonist has pulled in: ``position = (extension_antagonist - extension_agonist) / 2``.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Unit


class PairState(NamedTuple):
    """Measurements of a pair in one cycle.

    Parameters
    ----------
    t : float
        Time of the cycle, s.
    position : float
        Position of the pair, m.
    agonist, antagonist : float
        Monitored chamber pressures, Pa gauge.
    """

    t: float
    position: float
    agonist: float
    antagonist: float


class PairReference(NamedTuple):
    """The wanted motion of a pair: position (m), velocity (m/s), acceleration (m/s²)."""

    position: float
    velocity: float
    acceleration: float


class PairCommand(NamedTuple):
    """Pressure setpoints of a pair, Pa gauge."""

    agonist: float
    antagonist: float


class PairEstimate(NamedTuple):
    """A controller's estimate of a pair.

    Parameters
    ----------
    velocity : float
        Of the pair, m/s.
    disturbance : float
        Force that the pressures do not explain, N, positive along the position.
    """

    velocity: float
    disturbance: float


@dataclass(frozen=True, slots=True)
class PairModel:
    """Nominal mechanics of the pair, which its controllers compute with.

    Parameters
    ----------
    area : float
        Effective piston area of one chamber (rod side), m².
    mass : float
        Moving mass referred to the pair's position, kg.
    base_pressure : float
        Co-contraction: the mean of both setpoints, Pa gauge.
    pressure_min, pressure_max : float
        Range of the regulators, Pa gauge.
    regulator_bandwidth : float
        Natural frequency of the regulators' second-order response, rad/s.
    regulator_damping : float
        Its damping ratio.
    regulator_dead_time : float
        From a setpoint until its monitor begins to follow it, s.
    regulator_monitor_time : float
        The part of it that is the monitor's filter, for which the pressure does not wait, s.
    coulomb, breakaway : float
        Friction of the whole pair while sliding and when it starts to slide, N.
    stribeck_velocity : float
        Where breakaway has faded into Coulomb friction, m/s.
    viscous : float
        Viscous friction of the whole pair, N s/m.
    stiffness : float
        Of what pulls it back to where it should be, whatever the laws do, N/m; negative: it is
        pulled on, and falls. The laws leave it to their loops, whose margins depend on it.
    """

    area: Annotated[float, Unit("m^2"), Gt(0)]
    mass: Annotated[float, Unit("kg"), Gt(0)]
    base_pressure: Annotated[float, Unit("Pa"), Ge(0)]
    pressure_min: Annotated[float, Unit("Pa"), Ge(0)]
    pressure_max: Annotated[float, Unit("Pa"), Gt(0)]
    regulator_bandwidth: Annotated[float, Unit("rad/s"), Gt(0)]
    regulator_damping: Annotated[float, Gt(0)]
    coulomb: Annotated[float, Unit("N"), Ge(0)]
    breakaway: Annotated[float, Unit("N"), Ge(0)]
    stribeck_velocity: Annotated[float, Unit("m/s"), Gt(0)]
    viscous: Annotated[float, Unit("N s/m"), Ge(0)]
    regulator_dead_time: Annotated[float, Unit("s"), Ge(0)] = 0.0
    regulator_monitor_time: Annotated[float, Unit("s"), Ge(0)] = 0.0
    stiffness: Annotated[float, Unit("N/m")] = 0.0

    @property
    def air_dead_time(self) -> float:
        """From a setpoint until the pressure begins to follow it, s."""
        return max(self.regulator_dead_time - self.regulator_monitor_time, 0.0)
