"""What a path of the arm's hand is, whoever draws it."""

from abc import ABC, abstractmethod
from typing import Protocol, runtime_checkable

from controllers.arm.kinematics import Dimensions
from controllers.arm.types import Joints, Pose, Twist, Vector


class Trajectory(Protocol):
    """A path with its nominal time: where the hand would be if it always kept its speed.

    Attributes
    ----------
    start : tuple of float
        Joints at its beginning, rad.
    duration : float
        Nominal, s.
    speed, turn_rate : float
        Of the hand, m/s and rad/s.
    """

    start: Joints
    duration: float
    speed: float
    turn_rate: float

    def pose(self, t: float) -> Pose:
        """Return the pose at a nominal time, s."""

    def twist(self, t: float) -> Twist:
        """Return the twist at a nominal time, s."""

    def command_at(self, gone: float) -> Twist:
        """Return the twist that a singularity-consistent law scales, where its sign turns back."""

    def foot(self, position: Vector) -> Vector:
        """Return the place of the path that is nearest to a tool point, base axes, m."""


@runtime_checkable
class ThroughPlaces(Protocol):
    """A path through places that somebody has given."""

    def between(self, t: float) -> str:
        """Return in words between which of its places it is at a nominal time, s."""


def where_on(trajectory: object, t: float) -> str:
    """Return in words where on a path a nominal time (s) is, if places were given; else empty."""
    return f", {trajectory.between(t)}" if isinstance(trajectory, ThroughPlaces) else ""


class ArmPath(ABC):
    """Base of the paths of an arm's hand; another package's references inherit it.

    The plain laws follow any trajectory. The singularity-consistent ones plan lines and circles
    (`controllers.arm.trajectories`), `esc` a `TurnPath` as well, `look-ahead` that and the splines
    of `PosePath`, and refuse any other.
    """

    @abstractmethod
    def trajectory(self, arm: Dimensions) -> Trajectory:
        """Return the path for an arm of given dimensions.

        Raises
        ------
        InfeasibleMotion
            It leaves the workspace.
        """
