"""What a profile says of one antagonistic pair of cylinders."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Unit


@dataclass(frozen=True, slots=True)
class FrictionModel:
    """Friction of the whole pair as the controllers believe it.

    Parameters
    ----------
    coulomb, breakaway : float
        While sliding and when it starts to slide, N.
    stribeck_velocity : float
        Where breakaway has faded into Coulomb friction, m/s.
    viscous : float
        N s/m.
    """

    coulomb: Annotated[float, Unit("N"), Ge(0)]
    breakaway: Annotated[float, Unit("N"), Ge(0)]
    stribeck_velocity: Annotated[float, Unit("m/s"), Gt(0)]
    viscous: Annotated[float, Unit("N s/m"), Ge(0)]

    def __post_init__(self) -> None:
        if self.breakaway < self.coulomb:
            raise ValueError(
                f"breakaway ({self.breakaway:g} N) is below coulomb ({self.coulomb:g} N); "
                "friction at rest is at least that of sliding."
            )


@dataclass(frozen=True, slots=True)
class RegulatorModel:
    """Second-order response of the regulators as the controllers believe it.

    Parameters
    ----------
    bandwidth : float
        Natural frequency, rad/s.
    damping : float
        Damping ratio.
    """

    bandwidth: Annotated[float, Unit("rad/s"), Gt(0)] = 40.0
    damping: Annotated[float, Gt(0)] = 1.0


@dataclass(frozen=True, slots=True)
class CylinderLimits:
    """What the loop never permits; each is checked or enforced in every cycle.

    Parameters
    ----------
    position : tuple of float
        Permitted positions of the pair, m; outside is a fault.
    speed : float
        Permitted speed of the pair, m/s; above is a fault.
    pressure : tuple of float
        Permitted setpoints, Pa gauge; beyond is clipped.
    pressure_rate : float
        Greatest change of a setpoint, Pa/s; beyond is clipped.
    pair_force : float
        Greatest difference of the two chambers' forces, N; beyond is clipped.
    reading_age : float
        Oldest reading that control may use, s; older is a fault.
    mismatch : float
        How far the two rods may disagree about the pair's position, m: beyond it a wire is
        slack or broken, or an encoder is wrong.
    """

    position: tuple[Annotated[float, Unit("m")], Annotated[float, Unit("m")]]
    speed: Annotated[float, Unit("m/s"), Gt(0)]
    pressure: tuple[Annotated[float, Unit("Pa"), Ge(0)], Annotated[float, Unit("Pa"), Ge(0)]]
    pressure_rate: Annotated[float, Unit("Pa/s"), Gt(0)]
    pair_force: Annotated[float, Unit("N"), Gt(0)]
    reading_age: Annotated[float, Unit("s"), Gt(0)]
    mismatch: Annotated[float, Unit("m"), Gt(0)]

    def __post_init__(self) -> None:
        for name, (lower, upper) in (("position", self.position), ("pressure", self.pressure)):
            if not lower < upper:
                raise ValueError(f"{name}: the lower limit {lower:g} is not below {upper:g}.")


@dataclass(frozen=True, slots=True)
class CylinderSettings:
    """One antagonistic pair: which devices, what geometry, which limits.

    Parameters
    ----------
    regulators : str
        The device with the channels ``agonist`` and ``antagonist``.
    encoder_agonist, encoder_antagonist : str
        The devices that measure the rods.
    emergency_stop : str, optional
        The device that reads the emergency-stop contact.
    bore, rod, stroke : float
        Cylinder bore, rod diameter and stroke, m.
    home : float
        Rod extension at the pair's position zero, m.
    moving_mass : float
        Mass referred to the pair's position: two pistons and what they move, kg.
    base_pressure : float
        Co-contraction: the mean of both setpoints, Pa gauge.
    friction : FrictionModel
        Friction as the controllers believe it.
    limits : CylinderLimits
        What the loop never permits.
    regulator_response : RegulatorModel
        Response of the regulators as the controllers believe it.
    """

    regulators: str
    encoder_agonist: str
    encoder_antagonist: str
    bore: Annotated[float, Unit("m"), Gt(0)]
    rod: Annotated[float, Unit("m"), Gt(0)]
    stroke: Annotated[float, Unit("m"), Gt(0)]
    home: Annotated[float, Unit("m"), Gt(0)]
    moving_mass: Annotated[float, Unit("kg"), Gt(0)]
    base_pressure: Annotated[float, Unit("Pa"), Ge(0)]
    friction: FrictionModel
    limits: CylinderLimits
    emergency_stop: str | None = None
    regulator_response: RegulatorModel = field(default_factory=RegulatorModel)

    def __post_init__(self) -> None:
        if not self.rod < self.bore:
            raise ValueError(f"rod ({self.rod:g} m) does not fit into bore ({self.bore:g} m).")
        if not self.home < self.stroke:
            raise ValueError(f"home ({self.home:g} m) is not within stroke ({self.stroke:g} m).")
        reach = min(self.home, self.stroke - self.home)
        lower, upper = self.limits.position
        if max(-lower, upper) > reach:
            raise ValueError(
                f"limits.position {lower:g} … {upper:g} m exceeds what the stroke leaves "
                f"around home, ±{reach:g} m."
            )
        low, high = self.limits.pressure
        if not low <= self.base_pressure <= high:
            raise ValueError(
                f"base_pressure ({self.base_pressure:g} Pa) is outside limits.pressure "
                f"{low:g} … {high:g} Pa."
            )

    @property
    def area(self) -> float:
        """Effective piston area on the rod side, m²."""
        return math.pi / 4 * (self.bore**2 - self.rod**2)
