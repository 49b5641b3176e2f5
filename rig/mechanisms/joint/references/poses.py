"""Poses of the spherical joint, one after the other.

References of the joint say where the ring's axis points, whatever wires and conventions a
controller uses. Every one starts and ends at rest.
"""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Gt, Interval, MinLen, Unit

from controllers.spherical_joint.great_circle import great_circle
from controllers.spherical_joint.poses import Vector, axis_from_tilt
from controllers.spherical_joint.types import JointReference
from rig.hal.motion import Segment
from rig.mechanisms.joint.motion import JointDrawing

Tilt = Annotated[float, Unit("rad"), Interval(ge=0.0, lt=math.pi / 2)]
Angle = Annotated[float, Unit("rad")]
Duration = Annotated[float, Unit("s"), Gt(0)]

_ZERO: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class JointPose:
    """A direction of the ring's axis.

    Parameters
    ----------
    tilt : float
        From upright, rad.
    azimuth : float
        Towards which side, from +X towards +Y, rad.
    """

    tilt: Tilt
    azimuth: Angle = 0.0

    @property
    def axis(self) -> Vector:
        """The ring's axis, a unit vector."""
        return axis_from_tilt(self.tilt, self.azimuth)


@dataclass(frozen=True, slots=True)
class JointPoses(JointDrawing):
    """Minimum-jerk moves from pose to pose, with a dwell in each.

    Parameters
    ----------
    poses : tuple of JointPose
        In their order.
    rise : float
        Time of each move, s.
    dwell : float
        Time in each pose, s; its second half is judged.
    """

    poses: Annotated[tuple[JointPose, ...], MinLen(2)]
    rise: Duration = 1.0
    dwell: Duration = 2.0
    _axes: tuple[Vector, ...] = field(init=False, repr=False, default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "_axes", tuple(pose.axis for pose in self.poses))

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self.dwell + (len(self.poses) - 1) * (self.rise + self.dwell)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The second half of each dwell but the first, ``"hold 20 deg at 90 deg #1"``."""
        each = self.rise + self.dwell
        return tuple(
            Segment(
                f"hold {math.degrees(pose.tilt):g} deg at {math.degrees(pose.azimuth):g} deg "
                f"#{number}",
                number * each + 0.5 * self.dwell,
                number * each + self.dwell,
            )
            for number, pose in enumerate(self.poses)
            if number > 0
        )

    def at(self, t: float) -> JointReference:
        """Return the desired motion at `t`."""
        each = self.rise + self.dwell
        number = min(int(t // each), len(self._axes) - 1)
        if number == len(self._axes) - 1:
            return JointReference(self._axes[-1], _ZERO, _ZERO)
        into = t - number * each - self.dwell
        return great_circle(self._axes[number], self._axes[number + 1], self.rise, into)
