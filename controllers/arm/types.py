"""The values that pass through the loop of the arm."""

from typing import NamedTuple

Vector = tuple[float, float, float]
Rotation = tuple[Vector, Vector, Vector]
"""Rows of a rotation matrix, base from tool."""
Joints = tuple[float, float, float, float, float, float]
"""One value per joint, q1 … q6."""
AT_REST: Joints = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Pose(NamedTuple):
    """Pose of the tool: position of its point (m) and rotation, base from tool."""

    position: Vector
    rotation: Rotation


class Twist(NamedTuple):
    """Velocity of the tool in the base's axes: linear (m/s) and angular (rad/s) velocity."""

    linear: Vector
    angular: Vector


class ArmState(NamedTuple):
    """Measurements of an arm in one cycle.

    Parameters
    ----------
    t : float
        Time of the cycle, s.
    positions : tuple of float
        Of the joints, rad.
    velocities : tuple of float
        Of the joints, rad/s.
    """

    t: float
    positions: Joints
    velocities: Joints


class ArmReference(NamedTuple):
    """The wanted motion of an arm in one cycle.

    Parameters
    ----------
    positions, velocities : tuple of float
        Of the joints on the planned motion, rad and rad/s.
    following : bool
        Whether the law moves along its path: it advances by one period. If not, the arm is being
        brought to the path or kept from it, and the law commands the positions given here.
    twist : tuple of float, optional
        What is asked of the hand from outside: velocity (m/s) and angular velocity (rad/s), base
        axes. None: the law follows its path.
    """

    positions: Joints
    velocities: Joints
    following: bool
    twist: tuple[float, float, float, float, float, float] | None = None


class ArmCommand(NamedTuple):
    """Setpoints of the joints: positions (rad) and velocities (rad/s)."""

    positions: Joints
    velocities: Joints
