"""Parameters of the pneumatic plants.

Sources of the defaults: V, seen in a catalogue or paper; C, a catalogue value from general
knowledge; E, an estimate. Pressures are gauge where a catalogue gives gauge, and say so.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal, Protocol, Self

from annotated_types import Ge, Gt, Le, Lt, Unit

from drivers.sim.plants.regulator_settings import (
    RealRegulatorSettings,
    RealTubeSettings,
    RegulatorSettings,
    TubeSettings,
)

SOUND = 343.0
"""Speed of sound in a tube, m/s."""
_LEAST_MASS = 0.01
"""Of a carriage, kg: what settings allow."""


@dataclass(frozen=True, slots=True)
class SealFriction:
    """Friction of one cylinder's seals, and of the seat that its wire loads.

    Parameters
    ----------
    coulomb, breakaway : float
        While sliding, and when it starts to slide, at zero gauge pressure, N.
    stribeck_velocity : float
        Where breakaway has faded into Coulomb friction, m/s.
    viscous : float
        N s/m.
    pressure : float
        Growth of Coulomb friction and breakaway with gauge pressure, N/Pa.
    seat : float
        Friction of the carriage's seat over the sum of the wire tensions.
    """

    coulomb: float
    breakaway: float
    stribeck_velocity: float
    viscous: float
    pressure: float
    seat: float


SEALS = {
    # E; breakaway is 0.025 MPa on a 16 mm bore, as standard CJ2 (C). Shape: Tran and Yanada
    # 2013 (V), who also saw friction grow with the driving pressure. Seat: greased ABS on ABS,
    # 0.08 (E); the ball's normal force, tan(53 deg), times its lever, 0.75, is the wires' pull.
    "standard": SealFriction(3.0, 4.5, 8e-3, 25.0, 4e-6, 0.08),
    # E; fitted to low-speed cylinders that run down to 1 mm/s, SMC CJ2X (V).
    "low-speed": SealFriction(1.9, 2.0, 3e-3, 15.0, 4e-6, 0.04),
}
"""The two kinds of seals, by the name that a profile uses."""


@dataclass(frozen=True, slots=True)
class ActuatorSettings:
    """One cylinder whose rod side pulls a wire; the cap side is open.

    Parameters
    ----------
    bore, rod, stroke : float
        Bore, rod diameter and stroke, m. C: CJ2B16, 181.5 mm² on the rod side.
    dead_volume : float
        Of the chamber at full extension, m³, and of its tube where the plant has none: 1 cm³ and
        1 m of 2.5 mm. E.
    mass : float
        Piston, rod and clamp, kg. E.
    bristle_stiffness, bristle_damping : float
        LuGre sigma_0 and sigma_1, N/m and N s/m: 20 to 30 µm of pre-sliding. E.
    stop_stiffness, stop_damping : float
        Of the end stops, N/m and N s/m. E.
    """

    bore: Annotated[float, Unit("m"), Gt(0)] = 16e-3
    rod: Annotated[float, Unit("m"), Gt(0)] = 5e-3
    stroke: Annotated[float, Unit("m"), Gt(0)] = 60e-3
    dead_volume: Annotated[float, Unit("m^3"), Gt(0)] = 5.9e-6
    mass: Annotated[float, Unit("kg"), Ge(0.01)] = 0.045
    bristle_stiffness: Annotated[float, Unit("N/m"), Gt(0), Le(1e6)] = 1.5e5
    bristle_damping: Annotated[float, Unit("N s/m"), Ge(0), Le(200)] = 150.0
    stop_stiffness: Annotated[float, Unit("N/m"), Gt(0), Le(2e6)] = 5e5
    stop_damping: Annotated[float, Unit("N s/m"), Ge(0), Le(200)] = 100.0

    def __post_init__(self) -> None:
        if not self.rod < self.bore:
            raise ValueError(f"rod ({self.rod:g} m) does not fit into bore ({self.bore:g} m).")


@dataclass(frozen=True, slots=True)
class TubedActuatorSettings(ActuatorSettings):
    """A cylinder whose dead volume does not count the tube."""

    dead_volume: Annotated[float, Unit("m^3"), Gt(0)] = 1e-6


@dataclass(frozen=True, slots=True)
class WireSettings:
    """A wire: it pulls and never pushes.

    Parameters
    ----------
    stiffness, damping : float
        N/m and N s/m. E: 0.3 m of 0.8 mm 7x7 steel rope.
    """

    stiffness: Annotated[float, Unit("N/m"), Gt(0), Le(1e6)] = 80e3
    damping: Annotated[float, Unit("N s/m"), Ge(0), Le(200)] = 40.0


@dataclass(frozen=True, slots=True)
class CarriageSettings:
    """The carriage that the two wires of a pair move, as seen from the wires.

    Parameters
    ----------
    mass : float
        kg; with two pistons of 0.045 kg the pair moves 0.138 kg. E.
    seat_stiffness, seat_damping : float
        Of the seat before it slips (Dahl), N/m and N s/m. E.
    stop_stiffness : float
        Of the mechanical stops at both ends of the rods' stroke, N/m. E.
    restitution : float
        Share of its speed with which it comes back from a stop. E.
    """

    mass: Annotated[float, Unit("kg"), Ge(0.01)] = 0.048
    seat_stiffness: Annotated[float, Unit("N/m"), Gt(0), Le(1e6)] = 1.5e5
    seat_damping: Annotated[float, Unit("N s/m"), Ge(0), Le(200)] = 40.0
    stop_stiffness: Annotated[float, Unit("N/m"), Gt(0), Le(1e6)] = 5e5
    restitution: Annotated[float, Ge(0.15), Le(1)] = 0.4


class _Feed(Protocol):
    """The facts that every plant needs of what feeds a chamber; see `RegulatorSettings`."""

    @property
    def full_scale(self) -> float: ...
    @property
    def supply_pressure(self) -> float: ...
    @property
    def supply_time(self) -> float: ...
    @property
    def supply_volume(self) -> float: ...
    @property
    def monitor_noise(self) -> float: ...
    @property
    def monitor_error(self) -> float: ...


@dataclass(frozen=True, slots=True)
class CylinderPlantSettings:
    """The part of a plant's settings that every plant with pneumatic cylinders has.

    Parameters
    ----------
    seals : str
        ``standard`` or ``low-speed``.
    friction_scale : float
        Factor on all friction: of seals and seats, and of wires that slide.
    stribeck_scale : float
        Factor on the seals' Stribeck velocity.
    friction_spread : float
        Bound of the relative deviation of a unit's friction; drawn per unit. E.
    home : float
        Rod extension at which all wires are just taut at home, m.
    leak : float
        Sonic conductance of the fault ``leak``, m³/(s Pa). E: the tube is off.
    substep : float
        Step of the integration, s.
    encoder_noise : float
        Of what a rod's encoder sees, before it rounds, rms, m.
    cylinder, wire
        Parameters of the parts, the same for every channel.
    """

    seals: Literal["standard", "low-speed"] = "standard"
    friction_scale: Annotated[float, Ge(0), Le(20)] = 1.0
    stribeck_scale: Annotated[float, Gt(0), Le(5)] = 1.0
    friction_spread: Annotated[float, Ge(0), Lt(1)] = 0.15
    home: Annotated[float, Unit("m"), Gt(0)] = 30e-3
    leak: Annotated[float, Unit("m^3/(s Pa)"), Ge(0)] = 1e-8
    substep: Annotated[float, Unit("s"), Ge(1e-6), Le(1e-4)] = 50e-6
    encoder_noise: Annotated[float, Unit("m"), Ge(0), Le(1e-3)] = 0.0
    cylinder: ActuatorSettings = field(default_factory=ActuatorSettings)
    wire: WireSettings = field(default_factory=WireSettings)

    def __post_init__(self) -> None:
        if not self.home < self.cylinder.stroke:
            raise ValueError(
                f"home ({self.home:g} m) is not within stroke ({self.cylinder.stroke:g} m)."
            )

    def variant(self) -> str:
        """Return which seals the cylinders have."""
        return self.seals

    def perturbed(self, *, friction: float, stribeck: float, wire_offset: float) -> Self:
        """Return the settings of a rig that differs from its profile."""
        return replace(
            self,
            friction_scale=self.friction_scale * (1.0 + friction),
            stribeck_scale=self.stribeck_scale * (1.0 + stribeck),
            home=self.home + wire_offset,
        )

    @property
    def feed(self) -> _Feed:
        """What sets a chamber's pressure."""
        raise NotImplementedError

    def believed(self, told: Mapping[str, float]) -> Self:
        """Return the settings of a plant that is as the laws are told that the rig is.

        Parameters
        ----------
        told : mapping
            ``area``, ``base_pressure``, ``coulomb``, ``stribeck_velocity``, and what a subclass
            takes of what feeds the chambers, SI.
        """
        seals, cylinder = SEALS[self.seals], self.cylinder
        area = told["area"]
        nominal = self._nominal_friction(told["base_pressure"], area)
        return replace(
            self,
            friction_scale=told["coulomb"] / nominal,
            stribeck_scale=told["stribeck_velocity"] / seals.stribeck_velocity,
            cylinder=replace(cylinder, bore=math.sqrt(4.0 * area / math.pi + cylinder.rod**2)),
        )

    def coulomb_friction(self, pressure: float, area: float) -> float:
        """Return a pair's Coulomb friction, N, as that of units is on average.

        Parameters
        ----------
        pressure : float
            Of both chambers, Pa.
        area : float
            Of a piston, m².
        """
        return self.friction_scale * self._nominal_friction(pressure, area)

    def _nominal_friction(self, pressure: float, area: float) -> float:
        """Return what is told as Coulomb friction, N: here of two seals and a seat.

        A pair at its base pressure: both wires load the seat.
        """
        seals = SEALS[self.seals]
        return 2.0 * (seals.coulomb + (seals.pressure + seals.seat * area) * pressure)


@dataclass(frozen=True, slots=True)
class PneumaticPlantSettings(CylinderPlantSettings):
    """Cylinders that electro-pneumatic regulators feed through tubes.

    Parameters
    ----------
    regulator, tube
        Parameters of the parts, the same for every channel.
    """

    regulator: RegulatorSettings = field(default_factory=RegulatorSettings)
    tube: TubeSettings = field(default_factory=TubeSettings)

    @property
    def feed(self) -> _Feed:
        """See `CylinderPlantSettings.feed`."""
        return self.regulator

    def believed(self, told: Mapping[str, float]) -> Self:
        """See `CylinderPlantSettings.believed`; besides, what is told of the regulators.

        Parameters
        ----------
        told : mapping
            ``regulator_bandwidth``, ``regulator_damping``, ``regulator_dead_time`` and
            ``regulator_monitor_time``, SI, among others.
        """
        # By its name: a dataclass with slots is made anew, which an empty super() does not see.
        like = CylinderPlantSettings.believed(self, told)
        return replace(like, regulator=believed_regulator(self.regulator, self.tube, told))


def believed_regulator(
    regulator: RegulatorSettings, tube: TubeSettings, told: Mapping[str, float]
) -> RegulatorSettings:
    """Return a regulator behind a tube that is as the laws are told.

    Parameters
    ----------
    told : mapping
        See `PneumaticPlantSettings.believed`.
    """
    # A calibration sees a dead time at the monitor: all of these come before it.
    monitor = told["regulator_monitor_time"]
    late = 0.5 * regulator.sampling + regulator.valve_time + monitor + tube.length / SOUND
    return replace(
        regulator,
        bandwidth=told["regulator_bandwidth"],
        damping=told["regulator_damping"],
        dead_time=max(told["regulator_dead_time"] - late, 0.0),
        monitor_time=monitor,
    )


def carriage_mass(moving: float, cylinder: ActuatorSettings) -> float:
    """Return a carriage's mass, kg, of what a pair moves in all."""
    return max(moving - 2.0 * cylinder.mass, _LEAST_MASS)


@dataclass(frozen=True, slots=True)
class PlantSettings(PneumaticPlantSettings):
    """One antagonistic pair of pneumatic cylinders.

    Parameters
    ----------
    carriage : CarriageSettings
        What the pair moves.
    """

    carriage: CarriageSettings = field(default_factory=CarriageSettings)

    def believed(self, told: Mapping[str, float]) -> Self:
        """See `PneumaticPlantSettings.believed`; besides, the carriage has the ``mass`` told."""
        like = PneumaticPlantSettings.believed(self, told)
        mass = carriage_mass(told["mass"], self.cylinder)
        return replace(like, carriage=replace(self.carriage, mass=mass))


@dataclass(frozen=True, slots=True)
class RealPairSettings(PlantSettings):
    """One antagonistic pair with regulators, tubes and encoders as catalogues leave them."""

    encoder_noise: Annotated[float, Unit("m"), Ge(0), Le(1e-3)] = 1e-6
    regulator: RealRegulatorSettings = field(default_factory=RealRegulatorSettings)
    tube: RealTubeSettings = field(default_factory=RealTubeSettings)
    cylinder: TubedActuatorSettings = field(default_factory=TubedActuatorSettings)
