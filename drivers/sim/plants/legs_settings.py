"""Parameters of the legs' plant.

Sources of the defaults as in `drivers.sim.plants.settings`: E, an estimate. Dimensions, masses and
what the servos can give are the profile's geometry.
"""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Le, Unit

from drivers.sim.plants.leg_sensors import LegSensorSettings


@dataclass(frozen=True, slots=True)
class LegServoSettings:
    """One joint's servo: a spring to the commanded angle, cut at the maker's peak torque.

    Parameters
    ----------
    stiffness : float
        Of the position loop, N m/rad. E: the robot sags by a few millimetres, as such robots do.
    damping : float
        Of the velocity loop on the difference to the commanded rate, N m s/rad. E.
    inertia : float
        Of motor and gear at the joint, kg m². E.
    friction : float
        Dry friction of the gear at the joint, N m. E.
    viscous : float
        Viscous friction, N m s/rad. E.
    """

    stiffness: Annotated[float, Unit("N m/rad"), Gt(0), Le(2000)] = 150.0
    damping: Annotated[float, Unit("N m s/rad"), Ge(0), Le(50)] = 2.0
    inertia: Annotated[float, Unit("kg m^2"), Gt(0)] = 0.005
    friction: Annotated[float, Unit("N m"), Ge(0)] = 0.05
    viscous: Annotated[float, Unit("N m s/rad"), Ge(0)] = 0.1


@dataclass(frozen=True, slots=True)
class TerrainBlock:
    """A tread or a ramp on the level floor, across the robot's way.

    Parameters
    ----------
    start, length : float
        Where it begins ahead of where the robot stands ready, and how far it goes, m.
    height : float
        Of its upper side at its beginning, m.
    slope : float
        Of its upper side, rad; positive upwards ahead.
    """

    start: Annotated[float, Unit("m"), Interval(ge=-10.0, le=10.0)]
    length: Annotated[float, Unit("m"), Interval(gt=0.0, le=20.0)]
    height: Annotated[float, Unit("m"), Interval(ge=-0.5, le=2.0)] = 0.0
    slope: Annotated[float, Unit("rad"), Interval(ge=-0.5, le=0.5)] = 0.0


@dataclass(frozen=True, slots=True)
class LegsPlantSettings:
    """The legs, their upper body and the floor.

    Parameters
    ----------
    servo : LegServoSettings
        Of all twelve joints.
    floor_friction : float
        Coefficient between sole and floor. E.
    mass_spread, friction_spread : float
        Bounds of the relative deviations of each link's mass, and of each joint's friction and
        the floor's, from unit to unit.
    initial_hip_height : float
        Of the hips above the middle between the ankles while the robot stands ready, m.
    stand : tuple of float
        Angles of the twelve joints on the stand instead, as in a jig, rad. A robot whose soles
        are not on the floor then falls as soon as all servos have torque.
    fallen_tilt : float
        Lean of the waist beyond which the robot has fallen, rad.
    timestep : float
        Of the integration, s.
    terrain : tuple of TerrainBlock
        On the floor; of the floor's friction.
    sensors : LegSensorSettings
        How the load cells under the feet and the inertial sensor err, where a profile has them.
    ground_roll, ground_pitch : float
        By how much the whole ground is inclined about x and y, rad; what stands on it is not
        told. Positive: the left side is higher, the way ahead goes down.
    floor_pitch, floor_roll : float
        How the floor slopes below a robot that stands ready upright on it, as a plan with
        `start_pitch` and `start_roll` says it, rad: the way ahead goes down, the left side is
        higher. It goes through the middle between the soles.
    stiffness_spread : float
        Bound of the relative deviation of each servo's stiffness from unit to unit.
    """

    servo: LegServoSettings = field(default_factory=LegServoSettings)
    floor_friction: Annotated[float, Gt(0), Le(2)] = 0.8
    mass_spread: Annotated[float, Interval(ge=0.0, lt=0.5)] = 0.02
    friction_spread: Annotated[float, Interval(ge=0.0, lt=1.0)] = 0.2
    initial_hip_height: Annotated[float, Unit("m"), Gt(0)] = 0.190
    stand: tuple[Annotated[float, Unit("rad")], ...] = ()
    fallen_tilt: Annotated[float, Unit("rad"), Interval(gt=0.0, lt=1.6)] = 0.6
    timestep: Annotated[float, Unit("s"), Interval(ge=1e-4, le=5e-3)] = 2.5e-3
    terrain: tuple[TerrainBlock, ...] = ()
    sensors: LegSensorSettings = field(default_factory=LegSensorSettings)
    ground_roll: Annotated[float, Unit("rad"), Interval(ge=-0.3, le=0.3)] = 0.0
    ground_pitch: Annotated[float, Unit("rad"), Interval(ge=-0.3, le=0.3)] = 0.0
    floor_pitch: Annotated[float, Unit("rad"), Interval(ge=-0.5, le=0.5)] = 0.0
    floor_roll: Annotated[float, Unit("rad"), Interval(ge=-0.5, le=0.5)] = 0.0
    stiffness_spread: Annotated[float, Interval(ge=0.0, lt=0.9)] = 0.0

    def variant(self) -> None:
        """Return nothing: there is one kind of pair of legs only."""

    def perturbed(
        self, *, friction: float, stribeck: float, wire_offset: float
    ) -> "LegsPlantSettings":
        """Return them as they are: legs have no seals and no wires."""
        return self
