"""The poses of a path: what its settings mean for an arm of given dimensions."""

import copy
import math

from controllers.arm.circular_trajectory import CircularTrajectory
from controllers.arm.inverse import (
    BRANCHES,
    OutOfReach,
    reachable,
    wrist_of_pose,
)
from controllers.arm.kinematics import (
    Dimensions,
    forward,
    singularity_indices,
    wrist_centre,
)
from controllers.arm.paths import Circle, DwellLine, Line, TurnBack
from controllers.arm.trajectory import ArmPath, Trajectory
from controllers.arm.types import Joints, Pose, Twist, Vector
from controllers.arm.vectors import along, dot, minus, scaled, turned, unit
from controllers.bisection import bisect
from controllers.motion import InfeasibleMotion

ArmPathSettings = TurnBack | DwellLine | Circle | Line | ArmPath
"""Everything that an arm may be asked to do."""

_ON_SINGULARITY = 1e-9
"""A point with a smaller c (m) or S5 is on the singularity: the line may come from either side."""


class StraightTrajectory:
    """A line on which the tool may turn about a fixed axis, one way or out and back.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    start : tuple of float
        Joints, rad.
    direction : tuple of float
        Need not have unit length.
    speed : float
        m/s.
    axis : tuple of float
        Of the tool's turning.
    turn_rate : float
        rad/s.
    length : float, optional
        m; None goes to the boundary and back.
    travel : float
        How far away the boundary may be, m.
    depth : float, optional
        Of a region inside the boundary that the hand dwells in, m.
    dwell : float
        For how long, s.
    """

    def __init__(
        self,
        arm: Dimensions,
        start: Joints,
        direction: Vector,
        speed: float,
        axis: Vector = (0.0, 0.0, 1.0),
        turn_rate: float = 0.0,
        length: float | None = None,
        travel: float = 2.0,
        depth: float | None = None,
        dwell: float = 0.0,
    ) -> None:
        self.start = start
        self.depth = depth
        self.dwell = dwell
        self.speed = speed
        self.turn_rate = abs(turn_rate)
        self.direction = unit(direction, "direction")
        self._axis = unit(axis, "axis")
        self._rate = turn_rate
        self._origin = forward(arm, start)
        self.turns_back = length is None
        self.out = self._boundary(arm, travel) if length is None else length / speed
        """Nominal time to the boundary or to the end, s."""
        self.duration = 2.0 * self.out if self.turns_back else self.out
        self.command = Twist(scaled(self.direction, speed), scaled(self._axis, turn_rate))
        """The twist on the way out."""

    def slower(self, share: float) -> "StraightTrajectory":
        """Return the same line with a share of its speed."""
        other = copy.copy(self)
        other.speed, other.turn_rate = share * self.speed, share * self.turn_rate
        other.out, other.duration = self.out / share, self.duration / share
        other._rate = share * self._rate
        linear, angular = self.command
        other.command = Twist(scaled(linear, share), scaled(angular, share))
        return other

    def pose(self, t: float) -> Pose:
        """Return the pose at a nominal time; after the boundary the hand comes back."""
        gone = self.out - abs(self.out - t) if self.turns_back else t
        position = along(self._origin.position, self.direction, self.speed * gone)
        return Pose(position, turned(self._axis, self._rate * t, self._origin.rotation))

    def twist(self, t: float) -> Twist:
        """Return the twist at a nominal time."""
        linear, angular = self.command
        back = self.turns_back and t > self.out
        return Twist(scaled(linear, -1.0) if back else linear, angular)

    def command_at(self, gone: float) -> Twist:
        """Return the twist on the way out, wherever on the line."""
        del gone
        return self.command

    def foot(self, position: Vector) -> Vector:
        """Return the nearest place of the line through start and direction, m."""
        return along(self._origin.position, self.direction, self.distance(position))

    def distance(self, position: Vector) -> float:
        """Return how far along the line a point is, m."""
        return dot(minus(position, self._origin.position), self.direction)

    def time_at_radius(self, arm: Dimensions, radius: float) -> float:
        """Return the nominal time at which the wrist, on its way out, is so far (m), s.

        From the shoulder, and of a line on which the tool does not turn.
        """

        def is_nearer(t: float) -> bool:
            return self._from_shoulder(arm, wrist_of_pose(arm, self.pose(t))) < radius * radius

        step = self.out / 2000.0
        t = next(k * step for k in range(2001) if k == 2000 or not is_nearer((k + 1) * step))
        low, high = bisect(is_nearer, t, t + step)
        return 0.5 * (low + high)

    def _from_shoulder(self, arm: Dimensions, wrist: Vector) -> float:
        """Return the square of the distance of a wrist centre on the line from its shoulder, m²."""
        x, y, z = wrist
        if arm.a1 == 0.0:
            return x * x + y * y - arm.offset**2 + (z - arm.height) ** 2
        c, _, _ = singularity_indices(arm, self.start)
        out_x, out_y, _ = wrist_centre(arm, self.start)
        away = math.hypot(out_x, out_y)
        side = (x * out_y - y * out_x) / away if away else 0.0
        if arm.offset == 0.0 and abs(side) < _ON_SINGULARITY:
            # Within the arm's plane, where the wrist may go through the axis of q1.
            ahead = (x * out_x + y * out_y) / away if away else math.hypot(x, y)
        else:
            ahead = math.sqrt(max(x * x + y * y - arm.offset**2, 0.0))
        return (math.copysign(1.0, c) * ahead - arm.a1) ** 2 + (z - arm.height) ** 2

    def _boundary(self, arm: Dimensions, travel: float) -> float:
        """Return the nominal time after which the arm is stretched, s.

        Raises
        ------
        InfeasibleMotion
            It is not within `travel`, or the line meets the inner boundary before.
        """

        def wrist(t: float) -> Vector:
            position = along(self._origin.position, self.direction, self.speed * t)
            rotation = turned(self._axis, self._rate * t, self._origin.rotation)
            return wrist_of_pose(arm, Pose(position, rotation))

        def margin(t: float) -> tuple[float, float]:
            square = self._from_shoulder(arm, wrist(t))
            return (arm.a2 + arm.a3) ** 2 - square, square - (arm.a2 - arm.a3) ** 2

        last = travel / self.speed
        if last == math.inf:
            return last
        step = last / 2000.0
        t = 0.0
        while margin(t + step)[0] > 0.0:
            t += step
            x, y, _ = wrist(t)
            if math.hypot(x, y) < abs(arm.offset):
                raise InfeasibleMotion(
                    f"after {self.speed * t:.4f} m the line leads the wrist centre to "
                    f"{math.hypot(x, y):.4g} m from the axis of q1, nearer than the shoulder's "
                    f"offset of {abs(arm.offset):g} m."
                )
            if margin(t)[1] < 0.0:
                raise InfeasibleMotion(
                    f"after {self.speed * t:.4f} m the line meets the inner boundary, where the "
                    f"arm is folded, {abs(arm.a2 - arm.a3):g} m from the shoulder."
                )
            if t > last:
                raise InfeasibleMotion(
                    f"the line does not meet the boundary of the workspace, "
                    f"{arm.a2 + arm.a3:g} m from the shoulder, within {travel:g} m: "
                    f"there is no singularity to turn back at."
                )
        low, high = bisect(lambda middle: margin(middle)[0] > 0.0, t, t + step)
        return 0.5 * (low + high)


def make_trajectory(arm: Dimensions, settings: ArmPathSettings) -> Trajectory:
    """Return the poses of a path.

    Raises
    ------
    InfeasibleMotion
        The path leaves the workspace, or a line that is to turn back does not meet its boundary.
    """
    if isinstance(settings, ArmPath):
        return settings.trajectory(arm)
    if isinstance(settings, Circle):
        return CircularTrajectory(arm, settings)
    if isinstance(settings, DwellLine):
        return StraightTrajectory(
            arm,
            settings.start,
            settings.direction,
            settings.speed,
            travel=settings.travel,
            depth=settings.depth,
            dwell=settings.dwell,
        )
    if isinstance(settings, TurnBack):
        return StraightTrajectory(
            arm,
            _turn_back_start(arm, settings),
            settings.direction,
            settings.speed,
            settings.axis,
            settings.turn_rate,
            travel=settings.travel,
        )
    return _line(arm, settings)


def _turn_back_start(arm: Dimensions, settings: TurnBack) -> Joints:
    if settings.touch is None:
        return settings.start
    q1, q2, _, q4, q5, q6 = settings.touch
    touch = (q1, q2, -arm.elbow_angle, q4, q5, q6)
    # The turn that the tool makes on the way is taken back, too.
    way = settings.distance / settings.speed
    return _nearest_start(
        arm,
        touch,
        settings.direction,
        settings.distance,
        settings.axis,
        settings.turn_rate * way,
        1,
    )


def _line(arm: Dimensions, settings: Line) -> StraightTrajectory:
    q1, q2, q3, q4, q5, q6 = settings.middle
    if settings.shoulder_distance is not None:
        elbow = q3 + arm.elbow_angle
        radius = math.sqrt(arm.a2**2 + arm.a3**2 + 2.0 * arm.a2 * arm.a3 * math.cos(elbow))
        lean = math.atan2(arm.a3 * math.sin(elbow), arm.a2 + arm.a3 * math.cos(elbow))
        sine = (settings.shoulder_distance - arm.a1) / radius
        if abs(sine) > 1.0:
            raise InfeasibleMotion(
                f"with q3 = {q3:.4f} rad the wrist is {radius:.4f} m from the shoulder and cannot "
                f"be {settings.shoulder_distance:g} m from the axis of q1."
            )
        q2 = math.asin(sine) - lean
    middle = (q1, q2, q3, q4, q5, q6)
    turn = settings.turn_rate * settings.before / settings.speed
    elbow_sign = 1 if math.sin(q3 + arm.elbow_angle) >= 0.0 else -1
    start = _nearest_start(
        arm, middle, settings.direction, settings.before, settings.axis, turn, elbow_sign
    )
    return StraightTrajectory(
        arm,
        start,
        settings.direction,
        settings.speed,
        settings.axis,
        settings.turn_rate,
        settings.before + settings.after,
    )


def _nearest_start(
    arm: Dimensions,
    point: Joints,
    direction: Vector,
    distance: float,
    axis: Vector,
    turn: float,
    elbow: int,
) -> Joints:
    """Return the joints from which a line leads to a point, the nearest to those there."""
    there = forward(arm, point)
    c, _, s5 = singularity_indices(arm, point)
    position = along(there.position, unit(direction, "direction"), -distance)
    pose = Pose(position, turned(unit(axis, "axis"), -turn, there.rotation))
    try:
        branches = [
            branch
            for branch in BRANCHES
            if branch.elbow == elbow
            and (abs(c) < _ON_SINGULARITY or branch.shoulder * c > 0.0)
            and (abs(s5) < _ON_SINGULARITY or branch.wrist * s5 > 0.0)
        ]
        found = reachable(arm, pose, branches, point)
    except OutOfReach as error:
        raise InfeasibleMotion(f"the line cannot be begun: {error}.") from error
    return min(found, key=lambda q: math.dist(q, point))
