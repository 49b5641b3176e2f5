"""Parameters of the pneumatic plants.

Sources of the defaults: V, seen in a catalogue or paper; C, a catalogue value from general
knowledge; E, an estimate. Pressures are gauge where a catalogue gives gauge, and say so.
"""

from dataclasses import dataclass, field, replace
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Interval, Le, Lt, Unit


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


@dataclass(frozen=True, slots=True)
class ActuatorSettings:
    """One cylinder whose rod side pulls a wire; the cap side is open.

    Parameters
    ----------
    bore, rod, stroke : float
        Bore, rod diameter and stroke, m. C: CJ2B16, 181.5 mm² on the rod side.
    dead_volume : float
        Of the chamber at full extension and of its tube, m³: 1 cm³ and 1 m of 2.5 mm. E.
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


@dataclass(frozen=True, slots=True)
class PneumaticPlantSettings:
    """The part of a plant's settings that every plant with pneumatic cylinders has.

    Parameters
    ----------
    seals : str
        ``standard`` or ``low-speed``.
    friction_scale : float
        Factor on all friction: of seals and seats, and of wires that slide.
    friction_spread : float
        Bound of the relative deviation of a unit's friction; drawn per unit. E.
    home : float
        Rod extension at which all wires are just taut at home, m.
    leak : float
        Sonic conductance of the fault ``leak``, m³/(s Pa). E: the tube is off.
    substep : float
        Step of the integration, s.
    regulator, cylinder, wire
        Parameters of the parts, the same for every channel.
    """

    seals: Literal["standard", "low-speed"] = "standard"
    friction_scale: Annotated[float, Ge(0), Le(5)] = 1.0
    friction_spread: Annotated[float, Ge(0), Lt(1)] = 0.15
    home: Annotated[float, Unit("m"), Gt(0)] = 30e-3
    leak: Annotated[float, Unit("m^3/(s Pa)"), Ge(0)] = 1e-8
    substep: Annotated[float, Unit("s"), Ge(1e-6), Le(1e-4)] = 50e-6
    regulator: RegulatorSettings = field(default_factory=RegulatorSettings)
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
            home=self.home + wire_offset,
        )


@dataclass(frozen=True, slots=True)
class PlantSettings(PneumaticPlantSettings):
    """One antagonistic pair of pneumatic cylinders.

    Parameters
    ----------
    stribeck_scale : float
        Factor on the seals' Stribeck velocity.
    carriage : CarriageSettings
        What the pair moves.
    """

    stribeck_scale: Annotated[float, Gt(0), Le(5)] = 1.0
    carriage: CarriageSettings = field(default_factory=CarriageSettings)

    def perturbed(self, *, friction: float, stribeck: float, wire_offset: float) -> Self:
        """Return the settings of a pair that differs from its profile."""
        # A dataclass with slots is a new class, which a bare super() would not find.
        changed = PneumaticPlantSettings.perturbed(
            self, friction=friction, stribeck=stribeck, wire_offset=wire_offset
        )
        return replace(changed, stribeck_scale=self.stribeck_scale * (1.0 + stribeck))
