"""A turn of the hand about an axis: a circle by centre and normal, or the tool about itself."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Gt, Unit

from controllers.arm.geometry import Angle, SixAngles
from controllers.arm.kinematics import Dimensions, forward
from controllers.arm.paths import Direction
from controllers.arm.trajectory import ArmPath
from controllers.arm.types import Joints, Pose, Rotation, Twist, Vector
from controllers.arm.vectors import along, dot, minus, scaled, turned, unit

Length = Annotated[float, Unit("m")]

_NO_TURN: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class TurnPath(ArmPath):
    """A turn from where the arm stands.

    Parameters
    ----------
    start : tuple of float
        Joints to start from, rad.
    axis : tuple of float
        About which the hand turns, the circle's normal; base axes, need not have unit length.
    centre : tuple of float, optional
        A point of the axis, m. None: the tool point, which then stays where it is.
    angle : float
        How far, rad; the sense is that of the axis.
    rate : float
        At most, rad/s.
    tool_turns : bool
        Whether the tool turns with the hand, or keeps its direction.
    """

    start: SixAngles
    axis: Direction
    centre: tuple[Length, Length, Length] | None = None
    angle: Annotated[Angle, Gt(0)] = math.pi
    rate: Annotated[float, Unit("rad/s"), Gt(0)] = 0.3
    tool_turns: bool = True

    def __post_init__(self) -> None:
        if self.centre is None and not self.tool_turns:
            raise ValueError("without a centre and with tool_turns: false nothing turns.")

    def trajectory(self, arm: Dimensions) -> "TurnTrajectory":
        """Return the path; see `ArmPath`."""
        return TurnTrajectory(arm, self)


class TurnTrajectory:
    """A turn as a trajectory; parameters are the arm and a `TurnPath`."""

    def __init__(self, arm: Dimensions, path: TurnPath) -> None:
        self.start: Joints = path.start
        self._hand = forward(arm, path.start)
        self._axis = unit(path.axis, "axis")
        through = self._hand.position if path.centre is None else path.centre
        height = dot(minus(self._hand.position, through), self._axis)
        self._centre = along(through, self._axis, height)
        self._arm_out = minus(self._hand.position, self._centre)
        self.rate, self._tool_turns = path.rate, path.tool_turns
        self.radius = math.hypot(*self._arm_out)
        self.duration = path.angle / path.rate
        self.speed = self.radius * path.rate
        self.turn_rate = path.rate if path.tool_turns else 0.0

    def pose(self, t: float) -> Pose:
        """Return the pose at a nominal time."""
        angle = self.rate * t
        rotation = self._hand.rotation
        if self._tool_turns:
            rotation = turned(self._axis, angle, rotation)
        return Pose(along(self._centre, self._out(angle), 1.0), rotation)

    def twist(self, t: float) -> Twist:
        """Return the twist at a nominal time."""
        x, y, z = self._out(self.rate * t)
        a, b, c = scaled(self._axis, self.rate)
        still = (0.0, 0.0, 0.0)
        return Twist(
            (b * z - c * y, c * x - a * z, a * y - b * x), (a, b, c) if self._tool_turns else still
        )

    def command_at(self, gone: float) -> Twist:
        """Return the twist at a nominal time: the turn is not taken back."""
        return self.twist(gone)

    def foot(self, position: Vector) -> Vector:
        """Return the nearest place of the circle, m."""
        away = minus(position, self._centre)
        flat = along(away, self._axis, -dot(away, self._axis))
        size = math.hypot(*flat)
        if size == 0.0 or self.radius == 0.0:
            return self._hand.position
        return along(self._centre, flat, self.radius / size)

    def _out(self, angle: float) -> Vector:
        """Return the way from the axis to the hand after an angle, m."""
        rows = turned(self._axis, angle, _NO_TURN)
        x, y, z = (dot(row, self._arm_out) for row in rows)
        return x, y, z
