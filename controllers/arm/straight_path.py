"""A line of the hand that is given by where it begins and how long it is."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Unit

from controllers.arm.geometry import SixAngles
from controllers.arm.kinematics import Dimensions
from controllers.arm.paths import Direction, Length, Speed
from controllers.arm.trajectory import ArmPath, Trajectory


@dataclass(frozen=True, slots=True)
class StraightPath(ArmPath):
    """A line from where the arm stands, one way.

    Parameters
    ----------
    start : tuple of float
        Joints to start from, rad.
    direction : tuple of float
        Of the hand, base axes; need not have unit length.
    length : float
        How far the hand goes, m.
    speed : float
        At most, m/s.
    axis : tuple of float
        About which the tool turns, base axes.
    turn_rate : float
        At full speed, rad/s.
    """

    start: SixAngles
    direction: Direction
    length: Length
    speed: Speed = 0.1
    axis: Direction = (0.0, 0.0, 1.0)
    turn_rate: Annotated[float, Unit("rad/s")] = 0.0

    def trajectory(self, arm: Dimensions) -> Trajectory:
        """Return the path; see `ArmPath`."""
        from controllers.arm.trajectories import StraightTrajectory

        return StraightTrajectory(
            arm,
            self.start,
            self.direction,
            self.speed,
            self.axis,
            self.turn_rate,
            self.length,
        )
