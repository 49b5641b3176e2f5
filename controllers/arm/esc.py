"""The enhanced singularity-consistent law: as the paper has it, and with what it lacks."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from controllers.arm.axis_path import axis_path_of_line
from controllers.arm.circles import elbow_circle_rates, elbow_rate, shoulder_circle_rates
from controllers.arm.decomposition import Scale, joint_rates, wrist_turning
from controllers.arm.dwell import (
    elbow_at_depth,
    integral_exact,
    integral_taylor,
    make_dwell,
    switch_of,
)
from controllers.arm.geometry import ArmGeometry
from controllers.arm.integration import advance_joints, bisect_period
from controllers.arm.kinematics import Dimensions, forward, singularity_indices
from controllers.arm.law import AnyArmLaw, ArmLaw, Motion, MotionEnd
from controllers.arm.plan import Sample
from controllers.arm.promises import ALL_JOINTS, Promises
from controllers.arm.region import (
    elbow_scale,
    pass_scale,
    region_for_acceleration,
    region_for_speed,
    region_for_twist,
)
from controllers.arm.retiming import follow_axis_path, retime
from controllers.arm.trajectories import CircularTrajectory, StraightTrajectory
from controllers.arm.trajectory import Trajectory
from controllers.arm.turn_back import (
    check_turn_back,
    dwelling,
    radial_share,
    time_at_depth,
    turn_back,
)
from controllers.arm.types import AT_REST, Joints
from controllers.motion import InfeasibleMotion


_ELBOW = 2
"""The place of q3 among the joints."""
_RADIAL = 1.0 - 1e-9
"""Cosine to the arm from which on a line is radial."""


@dataclass(frozen=True, slots=True)
class EscPaperSettings:
    """Choices that the paper leaves open or that its text contradicts.

    Parameters
    ----------
    dwell_integral : str
        ``taylor``: eq. (19). ``exact``: the elliptic integral that it approximates.
    dwell_slope : str
        Of b where the region is entered. ``zero`` costs a step in acceleration, but passes
        without stopping at the speed of Fig. 6; ``natural`` continues b's own slope, as the
        paper's text has it, and stops sooner.
    """

    dwell_integral: Literal["taylor", "exact"] = "taylor"
    dwell_slope: Literal["zero", "natural"] = "zero"


class EscPaper(ArmLaw[EscPaperSettings]):
    """The law of the paper.

    Promises: the hand stays on its path; q3 stays within its rate limit at the elbow's
    singularity as long as the tool does not turn; the hand turns back there without stopping.
    Does not promise anything of the other joints' rates, nor of accelerations; slows near the
    shoulder's and the wrist's singularity far more than their rates require, and an exact hit of
    them is never reached: the plan's outcome then is ``"stalls"``.

    References
    ----------
    Miyata et al., sections 2 to 4.
    """

    Settings = EscPaperSettings
    name = "esc-paper"
    promises = Promises(path=True)

    def promised(self, trajectory: Trajectory) -> Promises:
        """Return what the law promises on a path: of q3 only while the tool does not turn."""
        rates = (_ELBOW,) if trajectory.turn_rate == 0.0 else ()
        return self.promises._replace(rates=rates)

    def move(self, trajectory: Trajectory, end: MotionEnd) -> Motion:
        """Yield a sample per period."""
        if isinstance(trajectory, CircularTrajectory):
            return _circle(self, trajectory, end)
        if not isinstance(trajectory, StraightTrajectory):
            raise _unknown(self.name, trajectory)
        if trajectory.depth is not None:
            settings = self.settings
            return _dwell(
                self,
                trajectory,
                end,
                settings.dwell_integral,
                "quintic",
                natural=settings.dwell_slope == "natural",
            )
        sin_qs = region_for_speed(self.geometry, trajectory.speed)
        if not trajectory.turns_back:
            return self._line(trajectory, sin_qs, end)
        check_turn_back(self.geometry, self.arm, trajectory, sin_qs)
        if math.sin(trajectory.start[2] + self.arm.elbow_angle) < 0.0:
            raise InfeasibleMotion(
                f"q3 = {trajectory.start[2]:.4f} rad: with S3 < 0 the paper's b_v is -1 and the "
                f"hand would go against its command; start with q3 > 0, or take the law esc."
            )
        return turn_back(self.arm, trajectory, sin_qs, 1.0, _as_it_is, self.period, end)

    def _line(self, trajectory: StraightTrajectory, sin_qs: float, end: MotionEnd) -> Motion:
        """Yield a line past singularities inside the workspace, ``|b|`` for each of them.

        The whole twist is scaled with the product: scaling the wrist's chain alone would not
        keep the commanded direction.
        """
        arm, limits = self.arm, self.geometry.rate_limits
        side = 1.0 if math.sin(trajectory.start[2] + arm.elbow_angle) > 0.0 else -1.0
        c_s = 1.5 * trajectory.speed / limits[0]
        s5_s = 1.5 * self._greatest_turning(trajectory) / min(limits[3], limits[5])
        linear, angular = trajectory.command

        def scale_at(q: Joints) -> Scale:
            c, _, s5 = singularity_indices(arm, q)
            share = pass_scale(c, c_s) * pass_scale(s5, s5_s)
            b, square, per_elbow = elbow_scale(q[2] + arm.elbow_angle, sin_qs, side)
            return Scale(share * b, share * square, share * per_elbow)

        def rates(_: float, q: Joints) -> Joints:
            return joint_rates(arm, q, linear, angular, scale_at(q))

        return _integrated(self, trajectory, rates, scale_at, end)

    def _greatest_turning(self, trajectory: StraightTrajectory) -> float:
        """Return how fast the wrist has to turn across its singular plane at most, rad/s.

        The arm's own joints count at no more than their limits: near the shoulder's singularity
        they are slowed by its region.
        """
        path = axis_path_of_line(self.arm, trajectory)
        greatest = 0.0
        limits = self.geometry.rate_limits
        for q, rate in path.samples(200):
            q1, q2, q3 = (min(max(rate[j], -limits[j]), limits[j]) for j in range(3))
            x, y, _ = wrist_turning(q, trajectory.command.angular, (q1, q2, q3))
            greatest = max(greatest, math.hypot(x, y))
        return greatest


@dataclass(frozen=True, slots=True)
class EscSettings:
    """Parts of the law that may be left out.

    Parameters
    ----------
    account_turning : bool
        Widen the region for what turning the tool moves the wrist centre by.
    limit_acceleration : bool
        Widen it for q3's acceleration limit.
    """

    account_turning: bool = True
    limit_acceleration: bool = True


class Esc(ArmLaw[EscSettings]):
    """The paper's law with what it lacks.

    Promises: the hand stays on its path; no joint exceeds its rate limit, at the elbow also while
    the tool turns; q3 keeps its acceleration limit on a radial line to the boundary; the command's
    sign is kept on either side of the elbow; exact hits of shoulder and wrist are passed, and
    near misses take no longer than the rate limits require; a dwell has its exact length and
    never stops. Does not promise the accelerations of near misses: see `look-ahead`.

    References
    ----------
    Miyata et al., whose equations are corrected and completed as the functions used here say.
    """

    Settings = EscSettings
    name = "esc"
    promises = Promises(rates=ALL_JOINTS, path=True)

    def promised(self, trajectory: Trajectory) -> Promises:
        """Return what the law promises on a path: accelerations of q3 on a radial line."""
        if not (
            isinstance(trajectory, StraightTrajectory)
            and trajectory.depth is None
            and trajectory.turns_back
            and trajectory.turn_rate == 0.0
            and self.settings.limit_acceleration
            and radial_share(self.arm, trajectory.start, trajectory.direction) > _RADIAL
        ):
            return self.promises
        return self.promises._replace(accelerations=(_ELBOW,))

    def region(self, trajectory: StraightTrajectory) -> float:
        """Return sin q_s for a line."""
        turning = trajectory.turn_rate if self.settings.account_turning else 0.0
        sin_qs = region_for_twist(self.geometry, trajectory.speed, turning)
        if self.settings.limit_acceleration:
            sin_qs = max(sin_qs, region_for_acceleration(self.geometry, trajectory.speed))
        return sin_qs

    def move(self, trajectory: Trajectory, end: MotionEnd) -> Motion:
        """Yield a sample per period."""
        if isinstance(trajectory, CircularTrajectory):
            return _circle(self, trajectory, end)
        if not isinstance(trajectory, StraightTrajectory):
            raise _unknown(self.name, trajectory)
        if trajectory.depth is not None:
            return _dwell(self, trajectory, end, "exact", "ramp", natural=True)
        if not trajectory.turns_back:
            path = axis_path_of_line(self.arm, trajectory)
            timing = retime(path, self.geometry.rate_limits, None)
            return follow_axis_path(trajectory, path, timing, self.period, end)
        sin_qs = self.region(trajectory)
        check_turn_back(self.geometry, self.arm, trajectory, sin_qs)
        side = 1.0 if math.sin(trajectory.start[2] + self.arm.elbow_angle) > 0.0 else -1.0
        slow = within_limits(self.geometry)
        return turn_back(self.arm, trajectory, sin_qs, side, slow, self.period, end)


def within_limits(geometry: ArmGeometry) -> Callable[[Joints], float]:
    """Return a function that tells by how much rates have to be slowed for the limits."""
    g1, g2, g3, g4, g5, g6 = (1.0 / limit for limit in geometry.rate_limits)

    def slow(rates: Joints) -> float:
        r1, r2, r3, r4, r5, r6 = rates
        worst = max(
            abs(r1) * g1, abs(r2) * g2, abs(r3) * g3, abs(r4) * g4, abs(r5) * g5, abs(r6) * g6
        )
        return 1.0 if worst <= 1.0 else 1.0 / worst

    return slow


def _as_it_is(_: Joints) -> float:
    return 1.0


def _dwell(
    law: AnyArmLaw,
    trajectory: StraightTrajectory,
    end: MotionEnd,
    integral: Literal["taylor", "exact"],
    profile: Literal["quintic", "ramp"],
    *,
    natural: bool,
) -> Motion:
    arm = law.arm
    assert trajectory.depth is not None
    q_s = elbow_at_depth(arm, trajectory.depth)
    enter = time_at_depth(arm, trajectory, q_s)
    # The direction at the border, seen by an arm that is moved there in its plane's geometry.
    at_border = forward_along(trajectory, arm, enter)
    cosine = radial_share(arm, at_border, trajectory.direction)
    if cosine < 0.05:
        raise InfeasibleMotion(
            f"the line enters the region almost along the boundary (cosine {cosine:.3f} to the "
            f"arm): eq. (14) needs a radial share, which would vanish within the region."
        )
    switch = switch_of(arm, q_s, trajectory.speed, cosine)
    if not natural:
        switch = switch._replace(rate=0.0)
    whole = integral_taylor(arm, q_s) if integral == "taylor" else integral_exact(arm, q_s)
    b = make_dwell(profile, whole, trajectory.dwell, switch)
    return dwelling(arm, trajectory, q_s, b, law.period, end)


def forward_along(trajectory: StraightTrajectory, arm: Dimensions, t: float) -> Joints:
    """Return the joints at a nominal time on the way out, on the branch of the start."""
    from controllers.arm.inverse import branch_of, inverse

    return inverse(arm, trajectory.pose(t), branch_of(arm, trajectory.start), trajectory.start)


def _circle(law: AnyArmLaw, trajectory: CircularTrajectory, end: MotionEnd) -> Motion:
    """Yield a circle through a singularity, at full speed throughout.

    References
    ----------
    Miyata et al., eq. (7)-(10).
    """
    arm, settings = law.arm, trajectory.settings
    side = float(settings.side)

    def rates(t: float, q: Joints) -> Joints:
        velocity = trajectory.wrist_velocity(t)
        if settings.through == "shoulder":
            return shoulder_circle_rates(arm, q, velocity, settings.rate)
        elbow = elbow_rate(
            arm, trajectory.r1, trajectory.r2, trajectory.gamma(t), settings.rate, q[2], side
        )
        return elbow_circle_rates(arm, q, velocity, elbow)

    return _integrated(law, trajectory, rates, lambda _: Scale(1.0, 1.0, 0.0), end)


def _integrated(
    law: AnyArmLaw,
    trajectory: Trajectory,
    rates: Callable[[float, Joints], Joints],
    scale_at: Callable[[Joints], Scale],
    end: MotionEnd,
) -> Motion:
    """Yield a motion to the end of a path that is followed one way."""
    period, arm = law.period, law.arm
    q, t = trajectory.start, 0.0
    straight = trajectory if isinstance(trajectory, StraightTrajectory) else None
    length = trajectory.speed * trajectory.duration
    longest = trajectory.duration if straight is None else 8.0 * trajectory.duration

    def left(t: float, q: Joints) -> float:
        if straight is None:
            return trajectory.duration - t
        return length - straight.distance(forward(arm, q).position)

    while t < longest:
        scale, now = scale_at(q), rates(t, q)
        command = trajectory.twist(t)
        yield Sample(q, now, scale.linear, scale.angular, command)
        after = advance_joints(rates, t, q, period, now)
        if left(t + period, after) <= 0.0:
            last, _ = bisect_period(rates, t, q, period, lambda at, there: left(at, there) > 0.0)
            yield Sample(advance_joints(rates, t, q, last), AT_REST, 0.0, 0.0, command)
            end.duration = t + last
            return
        q, t = after, t + period
    end.duration, end.outcome = t, "stalls"


def _unknown(law: str, trajectory: Trajectory) -> InfeasibleMotion:
    return InfeasibleMotion(
        f"{law} plans lines and circles, not a {type(trajectory).__name__}; "
        "inverse, dls and servo-halt follow any path."
    )
