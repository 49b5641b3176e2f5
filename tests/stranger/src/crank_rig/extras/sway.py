"""A path of our own for the arm: the hand sways out and back, without a jerk at either end."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Gt, Unit

from controllers.arm.geometry import SixAngles
from controllers.arm.kinematics import Dimensions, forward
from controllers.arm.trajectory import ArmPath
from controllers.arm.types import Pose, Twist, Vector

_STILL = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class ArmSway(ArmPath):
    """The hand goes up and comes back down; the tool does not turn.

    Parameters
    ----------
    start : tuple of float
        Joints to start from, rad.
    height : float
        m.
    time : float
        There and back, s.
    """

    start: SixAngles = (0.0, 0.6, 1.6, 0.3, -0.9, 0.0)
    height: Annotated[float, Unit("m"), Gt(0)] = 0.05
    time: Annotated[float, Unit("s"), Gt(0)] = 4.0

    def trajectory(self, arm: Dimensions) -> "Sway":
        """Return the path for an arm of given dimensions."""
        return Sway(self, forward(arm, self.start))


class Sway:
    """The path as the laws follow it, a `controllers.arm.trajectory.Trajectory`."""

    def __init__(self, settings: ArmSway, origin: Pose) -> None:
        self.start = settings.start
        self.duration = settings.time
        self.speed = math.pi * settings.height / settings.time
        self.turn_rate = 0.0
        self._height = settings.height
        self._rate = 2.0 * math.pi / settings.time
        self._origin = origin

    def pose(self, t: float) -> Pose:
        """Return the pose at a nominal time."""
        return self._at(0.5 * self._height * (1.0 - math.cos(self._rate * t)))

    def twist(self, t: float) -> Twist:
        """Return the twist at a nominal time."""
        return Twist((0.0, 0.0, self.speed * math.sin(self._rate * t)), _STILL)

    def command_at(self, gone: float) -> Twist:
        """Return the twist on the way up."""
        return Twist((0.0, 0.0, self.speed), _STILL)

    def foot(self, position: Vector) -> Vector:
        """Return the nearest place of the path."""
        height = position[2] - self._origin.position[2]
        return self._at(min(max(height, 0.0), self._height)).position

    def _at(self, height: float) -> Pose:
        x, y, z = self._origin.position
        return Pose((x, y, z + height), self._origin.rotation)
