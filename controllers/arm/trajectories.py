"""The poses of a path: what its settings mean for an arm of given dimensions."""

import copy
import math

from controllers.arm.inverse import (
    BRANCHES,
    Branch,
    OutOfReach,
    inverse,
    lean_of,
    nearest_turns,
    reachable,
    wrist_joints,
    wrist_of_pose,
)
from controllers.arm.kinematics import (
    Dimensions,
    base_from_forearm,
    forward,
    singularity_indices,
    wrist_centre,
)
from controllers.arm.paths import Circle, DwellLine, Line, TurnBack
from controllers.arm.trajectory import ArmPath, Trajectory
from controllers.arm.types import Joints, Pose, Rotation, Twist, Vector
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

        def margin(t: float) -> tuple[float, float]:
            position = along(self._origin.position, self.direction, self.speed * t)
            rotation = turned(self._axis, self._rate * t, self._origin.rotation)
            square = self._from_shoulder(arm, wrist_of_pose(arm, Pose(position, rotation)))
            return (arm.a2 + arm.a3) ** 2 - square, square - (arm.a2 - arm.a3) ** 2

        last = travel / self.speed
        if last == math.inf:
            return last
        step = last / 2000.0
        t = 0.0
        while margin(t + step)[0] > 0.0:
            t += step
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


class CircularTrajectory:
    """A circle of the hand through a singularity; the tool does not turn.

    Raises
    ------
    InfeasibleMotion
        The arm has a shoulder offset or a1, or the circle leaves the workspace.
    """

    def __init__(self, arm: Dimensions, settings: Circle) -> None:
        for words, length in (("shoulder offset", arm.offset), ("a1", arm.a1)):
            if length != 0.0:
                raise InfeasibleMotion(
                    f"a circle through the {settings.through}'s singularity needs an arm without "
                    f"{words}; this one's is {length:g} m."
                )
        self.settings, self._arm = settings, arm
        self.turn_rate = 0.0
        self.r2 = settings.radius
        self.speed = self.r2 * settings.rate
        self.duration = (settings.end - settings.begin) / settings.rate
        touch = self._touch(arm)
        self._q1, self._elbow = touch[0], 1 if math.sin(touch[2] + arm.elbow_angle) >= 0.0 else -1
        self._rotation: Rotation = forward(arm, touch).rotation
        tool = tuple(row[2] for row in self._rotation)
        self._tool = scaled(tool, arm.d6)  # type: ignore[arg-type]
        wrist = wrist_centre(arm, touch)
        if settings.through == "elbow":
            shoulder = (0.0, 0.0, arm.height)
            outwards = unit(minus(wrist, shoulder), "the stretched arm")
            self.r1 = arm.a2 + arm.a3 - self.r2
            if self.r1 <= 0.0:
                raise InfeasibleMotion(
                    f"a radius of {self.r2:g} m is no less than the reach of {arm.a2 + arm.a3:g} m."
                )
            c, s = math.cos(settings.plane), math.sin(settings.plane)
            self._along = base_from_forearm(touch[0], touch[1], (c, s, 0.0))
        else:
            self.r1 = self.r2
            self._along = (math.cos(touch[0]), math.sin(touch[0]), 0.0)
            outwards = (math.sin(touch[0]), -math.cos(touch[0]), 0.0)
        self._outwards = outwards
        self._centre = along(wrist, outwards, -self.r2)
        self.start = self._joints(arm, touch)

    def gamma(self, t: float) -> float:
        """Return the angle on the circle at a nominal time, rad."""
        return self.settings.begin + self.settings.rate * t

    def joints_at(self, t: float, near: Joints) -> list[Joints]:
        """Return the joints at a nominal time on each branch of the wrist, turns as at `near`.

        The singular angle is that of the circle, not one that a pose would say less and less of.

        References
        ----------
        Miyata et al., eq. (8), corrected, and (10).
        """
        pose, arm, half = self.pose(t), self._arm, 0.5 * self.gamma(t)
        x, y, z = wrist_of_pose(arm, pose)
        if self.settings.through == "shoulder":
            folded = [branch for branch in BRANCHES if branch.elbow == self._elbow]
            (_, q2, q3, *_), *_ = reachable(arm, pose, folded, near)
            c = 2.0 * self.r1 * math.sin(half)
            elbow = q3 + arm.elbow_angle
            arms = [(self._q1 + half, c, elbow)]
        else:
            root = math.sqrt(self.r1 * self.r2 / (arm.a2 * arm.a3))
            sine = root * math.sin(half)
            if abs(sine) > 1.0:
                raise OutOfReach(
                    f"the circle is nearer to the shoulder than {abs(arm.a2 - arm.a3):.9g} m"
                )
            elbow = 2.0 * self.settings.side * math.asin(sine)
            c, q1 = math.hypot(x, y), math.atan2(y, x)
            arms = [(q1, c, elbow), (q1 + math.pi, -c, elbow)]
        found = []
        for q1, c, elbow in arms:
            q2 = math.atan2(c, z - arm.height) - lean_of(arm, elbow)
            position = (q1, q2, elbow - arm.elbow_angle)
            for sign in (1, -1):
                q = (*position, *wrist_joints(arm, pose, position, sign, near))
                found.append(nearest_turns(q, near))
        return found

    def wrist_velocity(self, t: float) -> Vector:
        """Return the wrist centre's, which is the hand's, m/s."""
        gamma = self.gamma(t)
        forth = self.speed * math.cos(gamma)
        inwards = -self.speed * math.sin(gamma)
        return along(scaled(self._along, forth), self._outwards, inwards)

    def pose(self, t: float) -> Pose:
        """Return the pose at a nominal time."""
        gamma = self.gamma(t)
        forth = along(self._centre, self._along, self.r2 * math.sin(gamma))
        wrist = along(forth, self._outwards, self.r2 * math.cos(gamma))
        return Pose(along(wrist, self._tool, 1.0), self._rotation)

    def twist(self, t: float) -> Twist:
        """Return the twist at a nominal time."""
        return Twist(self.wrist_velocity(t), (0.0, 0.0, 0.0))

    def command_at(self, gone: float) -> Twist:
        """Return the twist at a nominal time: circles are not turned back on."""
        return self.twist(gone)

    def foot(self, position: Vector) -> Vector:
        """Return the nearest place of the circle, m."""
        offset = minus(minus(position, self._tool), self._centre)
        x, y = dot(offset, self._along), dot(offset, self._outwards)
        share = self.r2 / math.hypot(x, y)
        centre = along(self._centre, self._tool, 1.0)
        return along(along(centre, self._along, share * x), self._outwards, share * y)

    def _touch(self, arm: Dimensions) -> Joints:
        q1, q2, q3, q4, q5, q6 = self.settings.touch
        if self.settings.through == "elbow":
            return q1, q2, -arm.elbow_angle, q4, q5, q6
        elbow = q3 + arm.elbow_angle
        lean = math.atan2(arm.a3 * math.sin(elbow), arm.a2 + arm.a3 * math.cos(elbow))
        return q1, -lean, q3, q4, q5, q6

    def _joints(self, arm: Dimensions, touch: Joints) -> Joints:
        half = math.sin(0.5 * self.settings.begin)
        if abs(half) < _ON_SINGULARITY:  # no inverse says how the joints get through
            return self._at_touch(arm, touch)
        side = 1 if half >= 0.0 else -1
        elbow = 1 if math.sin(touch[2] + arm.elbow_angle) >= 0.0 else -1
        wrist = 1 if math.sin(touch[4]) >= 0.0 else -1
        if self.settings.through == "elbow":
            c = arm.a2 * math.sin(touch[1]) + arm.a3 * math.sin(touch[1])
            branch = Branch(1 if c >= 0.0 else -1, side * self.settings.side, wrist)
        else:
            branch = Branch(side, elbow, wrist)
        try:
            return inverse(arm, self.pose(0.0), branch, touch)
        except OutOfReach as error:
            raise InfeasibleMotion(f"the circle cannot be begun: {error}.") from error

    def _at_touch(self, arm: Dimensions, touch: Joints) -> Joints:
        """Return the joints at the singularity, after as many times round as the circle begins."""
        q1, q2, q3, q4, q5, q6 = touch
        if self.settings.through == "shoulder":
            q1 += 0.5 * self.settings.begin
        wrist = 1 if math.sin(q5) >= 0.0 else -1
        q4, q5, q6 = wrist_joints(arm, self.pose(0.0), (q1, q2, q3), wrist, touch)
        return nearest_turns((q1, q2, q3, q4, q5, q6), touch)


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
