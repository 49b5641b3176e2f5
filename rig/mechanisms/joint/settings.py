"""What a profile says of the spherical joint."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Le, Unit

from controllers.spherical_joint.geometry import SphericalJointGeometry
from rig.mechanisms.cylinder.settings import RegulatorModel
from rig.mechanisms.joint.alarms.settings import JointAlarmSettings
from rig.mechanisms.joint.tolerances import JointTolerances

Four = tuple[str, str, str, str]
_Length = Annotated[float, Unit("m")]


@dataclass(frozen=True, slots=True)
class JointFriction:
    """Friction as the controllers believe it.

    Parameters
    ----------
    coulomb, breakaway : float
        Of a pair's two seals at base pressure, while sliding and when it starts to slide, N.
    stribeck_velocity : float
        Where breakaway has faded into Coulomb friction, m/s.
    viscous : float
        Of a pair, N s/m.
    ring : float
        Friction of the ring in its seat, at the wires' radius, over the sum of the tensions.
    wire : float
        Friction coefficient of the wires on the ball.
    """

    coulomb: Annotated[float, Unit("N"), Ge(0)]
    breakaway: Annotated[float, Unit("N"), Ge(0)]
    stribeck_velocity: Annotated[float, Unit("m/s"), Gt(0)]
    viscous: Annotated[float, Unit("N s/m"), Ge(0)]
    ring: Annotated[float, Ge(0), Le(1)] = 0.08
    wire: Annotated[float, Ge(0), Le(1)] = 0.10


@dataclass(frozen=True, slots=True)
class JointLimits:
    """What the loop never permits, and what a plan is refused for.

    Parameters
    ----------
    tilt : float
        Greatest tilt of the ring's axis, rad: planned and, with `tilt_excess`, measured.
    tilt_excess : float
        How far beyond it the measured tilt is a fault, rad.
    speed : float
        Permitted speed of a rod, m/s; above is a fault.
    pressure : tuple of float
        Permitted setpoints, Pa gauge; beyond is clipped.
    pressure_rate : float
        Greatest change of a setpoint, Pa/s; beyond is clipped.
    tension : tuple of float
        Least and greatest tension of a wire, N: the pressures are chosen so that they are kept.
    seat_margin : float
        Least angle between the wires' net force and the edge of the ring's contact cone, rad.
    free_wires : bool
        Whether a wire may leave the ball on the side that the ring tilts to.
    reading_age : float
        Oldest reading of encoders and regulators that control may use, s; older is a fault.
    residual : float
        How far the four rods may be from agreeing on one pose, m.
    disagreement : float
        How far camera and encoders may differ about the marker, m.
    grace : float
        How long either may last before it is a fault, s.
    """

    tilt: Annotated[float, Unit("rad"), Gt(0), Le(math.pi / 2)]
    speed: Annotated[float, Unit("m/s"), Gt(0)]
    pressure: tuple[Annotated[float, Unit("Pa"), Ge(0)], Annotated[float, Unit("Pa"), Ge(0)]]
    pressure_rate: Annotated[float, Unit("Pa/s"), Gt(0)]
    tension: tuple[Annotated[float, Unit("N"), Ge(0)], Annotated[float, Unit("N"), Gt(0)]]
    reading_age: Annotated[float, Unit("s"), Gt(0)]
    tilt_excess: Annotated[float, Unit("rad"), Ge(0)] = math.radians(5.0)
    seat_margin: Annotated[float, Unit("rad"), Interval(ge=-math.pi, le=math.pi / 2)] = 0.0
    free_wires: bool = True
    residual: Annotated[float, Unit("m"), Gt(0)] = 1.0e-3
    disagreement: Annotated[float, Unit("m"), Gt(0)] = 3.0e-3
    grace: Annotated[float, Unit("s"), Ge(0)] = 0.05

    def __post_init__(self) -> None:
        for name, (lower, upper) in (("pressure", self.pressure), ("tension", self.tension)):
            if not lower < upper:
                raise ValueError(f"{name}: the lower limit {lower:g} is not below {upper:g}.")


@dataclass(frozen=True, slots=True)
class JointSettings:
    """The spherical joint: which devices, what geometry, which limits.

    Parameters
    ----------
    regulators : str
        The device with the channels ch1 … ch4.
    encoders : tuple of str
        The devices that measure the rods of ch1 … ch4.
    bore, rod, stroke : float
        Cylinder bore, rod diameter and stroke, m.
    home : float
        Rod extension of every cylinder when the ring is upright, m.
    wire_offsets : tuple of float
        How much further than that each of them stands out there, m.
    moving_mass : float
        Mass referred to a pair's position: two pistons and the ring, kg.
    base_pressure : float
        Co-contraction: mean of the four setpoints at home, Pa gauge.
    friction : JointFriction
        Friction as the controllers believe it.
    limits : JointLimits
        What is never permitted.
    alarms : JointAlarmSettings
        What tells that something is broken, and how soon.
    geometry : SphericalJointGeometry
        Dimensions of ball, ring, wires and marker.
    wire_stiffness : float
        Of one wire, N/m.
    regulator_response : RegulatorModel
        Response of the regulators as the controllers believe it.
    tolerance : JointTolerances
        How far the joint may be off its drawing: what its calibration starts from.
    camera : str, optional
        The device that sees the marker.
    emergency_stop : str, optional
        The device that reads the emergency-stop contact.
    """

    regulators: str
    encoders: Four
    bore: Annotated[float, Unit("m"), Gt(0)]
    rod: Annotated[float, Unit("m"), Gt(0)]
    stroke: Annotated[float, Unit("m"), Gt(0)]
    home: Annotated[float, Unit("m"), Gt(0)]
    moving_mass: Annotated[float, Unit("kg"), Gt(0)]
    base_pressure: Annotated[float, Unit("Pa"), Gt(0)]
    friction: JointFriction
    limits: JointLimits
    geometry: SphericalJointGeometry = field(default_factory=SphericalJointGeometry)
    wire_offsets: tuple[_Length, _Length, _Length, _Length] = (0.0,) * 4
    wire_stiffness: Annotated[float, Unit("N/m"), Gt(0)] = 80e3
    alarms: JointAlarmSettings = field(default_factory=JointAlarmSettings)
    regulator_response: RegulatorModel = field(default_factory=RegulatorModel)
    tolerance: JointTolerances = field(default_factory=JointTolerances)
    camera: str | None = None
    emergency_stop: str | None = None

    def __post_init__(self) -> None:
        if not self.rod < self.bore:
            raise ValueError(f"rod ({self.rod:g} m) does not fit into bore ({self.bore:g} m).")
        if not self.home < self.stroke:
            raise ValueError(f"home ({self.home:g} m) is not within stroke ({self.stroke:g} m).")
        low, high = self.limits.pressure
        if not low <= self.base_pressure <= high:
            raise ValueError(
                f"base_pressure ({self.base_pressure:g} Pa) is outside limits.pressure "
                f"{low:g} … {high:g} Pa."
            )
        if len(set(self.encoders)) != len(self.encoders):
            raise ValueError("encoders: one device is named for two channels.")

    @property
    def area(self) -> float:
        """Effective piston area on the rod side, m²."""
        return math.pi / 4 * (self.bore**2 - self.rod**2)
