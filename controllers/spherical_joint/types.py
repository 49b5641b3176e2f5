"""The values that pass through the joint's loop, and what its controllers know of it.

Signs follow Kobayashi and Saito, eq. (6): a rod's position is the shortening of its wire from
home, positive when the cylinder has pulled it in, ``home_extension - extension``. Channels are in
the order of the anchors, ch1 … ch4; the pairs are (ch1, ch3) and (ch4, ch2), agonist first.
"""

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Unit

from controllers.spherical_joint.geometry import Quadruple, SphericalJointGeometry
from controllers.spherical_joint.poses import Vector


class CameraSample(NamedTuple):
    """A marker as a camera saw it.

    Parameters
    ----------
    marker : tuple of float
        In the base, m.
    t : float
        Middle of the exposure, s; also what tells one sample from the next.
    twist : float, optional
        Of the ring beyond the shortest tilt from home, rad; None if the marker does not show it.
    """

    marker: Vector
    t: float
    twist: float | None = None


class JointState(NamedTuple):
    """Measurements of the joint in one cycle.

    Parameters
    ----------
    t : float
        Time of the readings of the rods, s.
    rods : tuple of float
        Shortening of each wire as its cylinder's encoder says, m.
    pressures : tuple of float
        Monitored chamber pressures, Pa gauge.
    camera : CameraSample, optional
        The newest sample; it stays the same for many cycles.
    """

    t: float
    rods: Quadruple
    pressures: Quadruple
    camera: CameraSample | None = None


class Lap(NamedTuple):
    """The place of a reference in a repeated motion.

    Parameters
    ----------
    number : int
        Laps before this one.
    tick : int
        Cycles since it began.
    ticks : int
        Cycles of a lap.
    """

    number: int
    tick: int
    ticks: int


class JointReference(NamedTuple):
    """The wanted motion of the ring, whatever the convention of the pose.

    Parameters
    ----------
    axis, velocity, acceleration : tuple of float
        Of the ring's axis: unit vector, 1/s, 1/s².
    lap : Lap, optional
        Only of a motion that repeats itself, from which something can be learnt.
    base_pressure : float, optional
        Co-contraction instead of the model's: mean of the four setpoints at home, Pa gauge.
    push : tuple of float, optional
        Forces on the pairs (1, 3) and (4, 2), N, over the tensions that hold the pose: while
        there are any, nothing is controlled.
    """

    axis: Vector
    velocity: Vector
    acceleration: Vector
    lap: Lap | None = None
    base_pressure: float | None = None
    push: tuple[float, float] | None = None


class JointCommand(NamedTuple):
    """Pressure setpoints of the four chambers, Pa gauge."""

    ch1: float
    ch2: float
    ch3: float
    ch4: float


class JointEstimate(NamedTuple):
    """A controller's estimate of the joint.

    Parameters
    ----------
    marker : tuple of float
        Fused from encoders and camera, m; from encoders alone without one.
    encoder_marker : tuple of float
        From encoders alone, m.
    residual : float
        How far the four wires are from agreeing on a pose, m.
    rods : tuple of float
        Where the controller wanted the rods to be, m: inverse kinematics, stretch of the wires
        and what the camera corrected.
    tensions : tuple of float
        Tensions that hold the reference without friction, N.
    push : tuple of float, optional
        With what it pushes the two pairs, N, and leads the ring nowhere; None: it leads it.
    """

    marker: Vector
    encoder_marker: Vector
    residual: float
    rods: Quadruple
    tensions: Quadruple
    push: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class JointModel:
    """Nominal mechanics of the joint, which its controllers compute with.

    Parameters
    ----------
    geometry : SphericalJointGeometry
        Dimensions.
    area : float
        Effective piston area of one chamber (rod side), m².
    mass : float
        That a pair moves, referred to its position: two pistons and the ring, kg.
    base_pressure : float
        Mean of the four setpoints at home, Pa gauge: co-contraction.
    pressure_min, pressure_max : float
        Range of the regulators, Pa gauge.
    regulator_bandwidth, regulator_damping : float
        Of the regulators' second-order response: rad/s and 1.
    regulator_dead_time : float
        From a setpoint until its monitor begins to follow it, s.
    regulator_monitor_time : float
        The part of it that is the monitor's filter, s.
    coulomb, breakaway : float
        Friction of a pair's two seals while sliding and when it starts to slide, at base
        pressure, N.
    stribeck_velocity : float
        Where breakaway has faded into Coulomb friction, m/s.
    viscous : float
        Of a pair, N s/m.
    ring_friction : float
        Friction of the ring in its seat, at the wires' radius, over the sum of the tensions.
    wire_friction : float
        Friction coefficient of the wires on the ball.
    wire_stiffness : float
        Of one wire, N/m.
    least_tension, most_tension : float
        Of a wire, N, at any time.
    """

    geometry: SphericalJointGeometry = field(default_factory=SphericalJointGeometry)
    area: Annotated[float, Unit("m^2"), Gt(0)] = 181.43e-6
    mass: Annotated[float, Unit("kg"), Gt(0)] = 0.138
    base_pressure: Annotated[float, Unit("Pa"), Gt(0)] = 0.12e6
    pressure_min: Annotated[float, Unit("Pa"), Ge(0)] = 0.0
    pressure_max: Annotated[float, Unit("Pa"), Gt(0)] = 0.5e6
    regulator_bandwidth: Annotated[float, Unit("rad/s"), Gt(0)] = 40.0
    regulator_damping: Annotated[float, Gt(0)] = 1.0
    regulator_dead_time: Annotated[float, Unit("s"), Ge(0)] = 0.0
    regulator_monitor_time: Annotated[float, Unit("s"), Ge(0)] = 0.0
    coulomb: Annotated[float, Unit("N"), Ge(0)] = 7.0
    breakaway: Annotated[float, Unit("N"), Ge(0)] = 10.0
    stribeck_velocity: Annotated[float, Unit("m/s"), Gt(0)] = 8e-3
    viscous: Annotated[float, Unit("N s/m"), Ge(0)] = 50.0
    ring_friction: Annotated[float, Ge(0)] = 0.08
    wire_friction: Annotated[float, Ge(0)] = 0.10
    wire_stiffness: Annotated[float, Unit("N/m"), Gt(0)] = 80e3
    least_tension: Annotated[float, Unit("N"), Ge(0)] = 5.0
    most_tension: Annotated[float, Unit("N"), Gt(0)] = 90.0

    def __post_init__(self) -> None:
        if not self.least_tension < self.area * self.base_pressure < self.most_tension:
            raise ValueError(
                f"base_pressure ({self.base_pressure:g} Pa) pulls each wire with "
                f"{self.area * self.base_pressure:.3g} N, which is not between least_tension "
                f"({self.least_tension:g} N) and most_tension ({self.most_tension:g} N)."
            )
