"""A circle through the elbow's or the shoulder's singularity as poses, and its joints."""

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
from controllers.arm.kinematics import Dimensions, base_from_forearm, forward, wrist_centre
from controllers.arm.paths import Circle
from controllers.arm.types import Joints, Pose, Rotation, Twist, Vector
from controllers.arm.vectors import along, dot, minus, scaled, unit
from controllers.motion import InfeasibleMotion

_AT_TOUCH = 1e-9
"""Sine of half the angle from the touch: what is less is at the singularity."""


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
                    f"the circle is nearer to the shoulder than {abs(arm.a2 - arm.a3):.9g} m",
                    abs(arm.a2 - arm.a3) - math.hypot(x, y, z - arm.height),
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
        if abs(half) < _AT_TOUCH:  # no inverse says how the joints get through
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
