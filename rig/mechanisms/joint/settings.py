"""What a profile says of the spherical joint."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Le, Unit

from controllers.spherical_joint.geometry import SphericalJointGeometry
from rig.hal.rising import Rising
from rig.hal.rules import Rules
from rig.mechanisms.joint.alarms.settings import JointAlarmSettings
from rig.mechanisms.joint.tolerances import JointTolerances
from rig.mechanisms.pneumatic.alarms.bounds import check_pressure_alarm
from rig.mechanisms.pneumatic.settings import (
    PneumaticLimits,
    PneumaticSettings,
    SealFriction,
    check_can_trip,
)

Four = tuple[str, str, str, str]
_Length = Annotated[float, Unit("m")]


_SWAY = 0.2
"""Share of the permitted tilt that a ring may sway by while nothing controls it."""
_WRAP = 1.0
"""A wire lies on so much of the ball, rad. E: upright it is somewhat more."""


@dataclass(frozen=True, slots=True)
class JointFriction(SealFriction):
    """Friction of a pair's seals at base pressure, and on the ball, as the controllers believe it.

    Parameters
    ----------
    ring : float
        Friction of the ring in its seat, at the wires' radius, over the sum of the tensions.
    wire : float
        Friction coefficient of the wires on the ball.
    """

    ring: Annotated[float, Ge(0), Le(1)] = 0.08
    wire: Annotated[float, Ge(0), Le(1)] = 0.10

    def of_pair(self, tension: float) -> SealFriction:
        """Return what a pair feels of seals, ring and its two wires, all wires at a tension, N."""
        ball = (4.0 * self.ring + 2.0 * self.wire * _WRAP) * tension
        return SealFriction(
            self.coulomb + ball, self.breakaway + ball, self.stribeck_velocity, self.viscous
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class JointLimits(PneumaticLimits):
    """Limits that the loop enforces, and by which a plan is refused; see `PneumaticLimits`, too.

    Parameters
    ----------
    tilt : float
        Greatest tilt of the ring's axis, rad: planned and, with `tilt_excess`, measured.
    tilt_excess : float
        How far beyond it the measured tilt is a fault, rad.
    tension : tuple of float
        Least and greatest tension of a wire, N: the pressures are chosen so that they are kept.
    seat_margin : float
        Least angle between the wires' net force and the edge of the ring's contact cone, rad.
    free_wires : bool
        Whether a wire may leave the ball on the side that the ring tilts to.
    residual : float
        How far the four rods may be from agreeing on one pose, m.
    disagreement : float
        How far camera and encoders may differ about the marker, m.
    grace : float
        How long either may last before it is a fault, s.
    """

    tilt: Annotated[float, Unit("rad"), Gt(0), Le(math.pi / 2)]
    tension: Annotated[
        tuple[Annotated[float, Unit("N"), Ge(0)], Annotated[float, Unit("N"), Gt(0)]],
        Rising("tension"),
    ]
    tilt_excess: Annotated[float, Unit("rad"), Interval(ge=0, le=math.pi / 2)] = math.radians(5.0)
    seat_margin: Annotated[float, Unit("rad"), Interval(ge=-math.pi, le=math.pi / 2)] = 0.0
    free_wires: bool = True
    residual: Annotated[float, Unit("m"), Gt(0)] = 1.0e-3
    disagreement: Annotated[float, Unit("m"), Gt(0)] = 3.0e-3
    grace: Annotated[float, Unit("s"), Interval(ge=0, le=10.0)] = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class JointSettings(PneumaticSettings):
    """The spherical joint, beside what `PneumaticSettings` says.

    Parameters
    ----------
    encoders : tuple of str
        The devices that measure the rods of ch1 … ch4.
    base_pressure : float
        Co-contraction: mean of the four setpoints at home, Pa gauge.
    friction : JointFriction
        Of seals, ring and wires.
    limits : JointLimits
        What is never permitted.
    wire_offsets : tuple of float
        How much further than `home` each of them stands out there, m.
    alarms : JointAlarmSettings
        What tells that something is broken, and how soon.
    geometry : SphericalJointGeometry
        Dimensions of ball, ring, wires and marker.
    tolerance : JointTolerances
        How far the joint may be off its drawing: what its calibration starts from.
    camera : str, optional
        The device that sees the marker.
    """

    encoders: Four
    base_pressure: Annotated[float, Unit("Pa"), Gt(0)]
    friction: JointFriction
    limits: JointLimits
    geometry: SphericalJointGeometry = field(default_factory=SphericalJointGeometry)
    wire_offsets: tuple[_Length, _Length, _Length, _Length] = (0.0,) * 4
    alarms: JointAlarmSettings = field(default_factory=JointAlarmSettings)
    tolerance: JointTolerances = field(default_factory=JointTolerances)
    camera: str | None = None

    def __post_init__(self) -> None:
        with Rules() as rule:
            rule.of(PneumaticSettings.__post_init__, self)
            if len(set(self.encoders)) != len(self.encoders):
                rule.broken("encoders: one device is named for two channels.")
            for name, limit in (
                ("limits.residual", self.limits.residual),
                ("limits.disagreement", self.limits.disagreement),
            ):
                rule.of(check_can_trip, name, limit, self.stroke, "m", "is the stroke")
            rule.of(check_pressure_alarm, self.alarms.pressure, self)

    @property
    def greatest_pressure(self) -> float:
        """The greatest pressure that a chamber is given, Pa gauge: that of the greatest tension."""
        return min(self.limits.tension[1] / self.area, self.limits.pressure[1])

    @property
    def lowers_pressure(self) -> str:
        """See `PneumaticSettings.lowers_pressure`."""
        if self.greatest_pressure == self.limits.pressure[1]:
            return "limits.pressure"
        return "limits.tension"

    @property
    def sway(self) -> float:
        """How far a rod may go while nothing controls the ring, m."""
        return _SWAY * self.limits.tilt * self.geometry.ball_radius
