"""Motions that both singularity-consistent laws make alike: dwells, circles, lines past."""

import math
from collections.abc import Callable
from typing import Literal

import numpy as np

from controllers.arm.axis_path import AxisPath, axis_path_of_line
from controllers.arm.circles import elbow_circle_rates, elbow_rate, shoulder_circle_rates
from controllers.arm.circular_trajectory import CircularTrajectory
from controllers.arm.decomposition import Scale, full_scale, joint_rates
from controllers.arm.dwell import (
    elbow_at_depth,
    elbow_peak,
    integral_exact,
    integral_taylor,
    make_dwell,
    switch_of,
)
from controllers.arm.integration import advance_joints, bisect_period
from controllers.arm.inverse import branch_of, inverse, reachable
from controllers.arm.kinematics import Dimensions, forward, wrist_in_plane
from controllers.arm.law import AnyArmLaw, Motion, MotionEnd
from controllers.arm.plan import Sample
from controllers.arm.promises import check_rates
from controllers.arm.trajectories import StraightTrajectory
from controllers.arm.trajectory import Trajectory
from controllers.arm.turn_back import check_start, dwelling, radial_share, time_at_depth
from controllers.arm.types import AT_REST, Joints
from controllers.motion import InfeasibleMotion

_NEAR_ANOTHER = 0.02
"""Sine of q5, or c in m: a circle that passes a second singularity nearer is not integrated."""
_KINDS = {"PoseTrajectory": "one through given places", "TurnTrajectory": "a turn"}
"""What people call a path of a class that not all laws plan."""
_NEAR = 1e-4
"""s, to either side of an instant at which a slope is wanted."""


def dwell_motion(
    law: AnyArmLaw,
    trajectory: StraightTrajectory,
    end: MotionEnd,
    integral: Literal["taylor", "exact"],
    profile: Literal["quintic", "ramp"],
    *,
    natural: bool,
) -> Motion:
    """Return a line to the boundary and back that stays near it; see `dwelling`.

    Raises
    ------
    InfeasibleMotion
        It starts too near, goes along the boundary, or would have to stop.
    """
    arm = law.arm
    assert trajectory.depth is not None
    q_s = elbow_at_depth(arm, trajectory.depth)
    enter = time_at_depth(arm, trajectory, q_s)
    check_start(arm, trajectory, full_scale(arm, trajectory.start))
    # The direction at the border, seen by an arm that is moved there in its plane's geometry.
    at_border = forward_along(trajectory, arm, enter, q_s)
    cosine = radial_share(arm, at_border, trajectory.direction)
    if cosine < 0.05:
        raise InfeasibleMotion(
            f"the line enters the region almost along the boundary (cosine {cosine:.3f} to the "
            f"arm): eq. (14) needs a radial share, which would vanish within the region."
        )
    bend = None
    if arm.a1 != 0.0 or arm.offset != 0.0:  # the boundary is no sphere
        before, after = (
            radial_share(arm, forward_along(trajectory, arm, t, q_s), trajectory.direction)
            for t in (enter - _NEAR, enter + _NEAR)
        )
        bend = (after - before) / (2.0 * _NEAR * trajectory.speed)
    switch = switch_of(arm, q_s, trajectory.speed, cosine, bend)
    if not natural:
        switch = switch._replace(rate=0.0)
    whole = integral_taylor(arm, q_s) if integral == "taylor" else integral_exact(arm, q_s)
    b = make_dwell(profile, whole, trajectory.dwell, switch)
    check_border(law, trajectory, enter, at_border, elbow_peak(arm, q_s, b))
    return dwelling(arm, trajectory, q_s, b, law, end)


def check_border(
    law: AnyArmLaw,
    trajectory: StraightTrajectory,
    enter: float,
    q: Joints,
    elbow: tuple[float, float],
) -> None:
    """Raise if a dwell needs too much at its region's border, between two samples of a plan.

    The shallower the region, the higher and the shorter are the peaks there.

    Parameters
    ----------
    law : ArmLaw
        Whose promises are to be kept.
    trajectory : StraightTrajectory
        The line.
    enter : float
        Nominal time of the border, s.
    q : tuple of float
        Joints there, rad.
    elbow : tuple of float
        When the elbow is fastest, s later, and how fast, rad/s.

    Raises
    ------
    TooFast
        A joint would pass a limit that the law keeps.
    """
    scale = Scale(1.0, 1.0, 1.0 / math.sin(q[2] + law.arm.elbow_angle))
    rates = joint_rates(law.arm, q, *trajectory.command, scale)
    after, peak = elbow
    rows = np.array([rates, (0.0, 0.0, peak, 0.0, 0.0, 0.0)])
    instants = np.array([enter, enter + after])
    check_rates(law.geometry, instants, rows, law.promised(trajectory))


def forward_along(
    trajectory: StraightTrajectory, arm: Dimensions, t: float, elbow: float
) -> Joints:
    """Return the joints at a nominal time on the way out, on the branch of the start.

    With `a1` a wrist that has gone through the axis of q1 is on another: it is the one on which
    the elbow's angle is about `elbow` (rad), whatever its sign.
    """
    start, branch = trajectory.start, branch_of(arm, trajectory.start)
    if arm.a1 == 0.0:
        return inverse(arm, trajectory.pose(t), branch, start)
    both = [branch, branch._replace(shoulder=-branch.shoulder)]
    found = reachable(arm, trajectory.pose(t), both, start)
    return min(found, key=lambda q: abs(math.cos(q[2] + arm.elbow_angle) - math.cos(elbow)))


def circle_motion(law: AnyArmLaw, trajectory: CircularTrajectory, end: MotionEnd) -> Motion:
    """Return a circle through a singularity, at full speed throughout.

    Where it leads through or past another one as well, the rates are quotients of roundings there:
    the joints then come from the poses.

    References
    ----------
    Miyata et al., eq. (7)-(10).
    """
    arm, settings = law.arm, trajectory.settings
    side = float(settings.side)
    path = axis_path_of_line(arm, trajectory, trajectory.joints_at)
    if _is_near_another(arm, path, settings.through):
        return _at_full_speed(law, trajectory, path, end)

    def rates(t: float, q: Joints) -> Joints:
        velocity = trajectory.wrist_velocity(t)
        if settings.through == "shoulder":
            return shoulder_circle_rates(arm, q, velocity, settings.rate)
        elbow = elbow_rate(
            arm, trajectory.r1, trajectory.r2, trajectory.gamma(t), settings.rate, q[2], side
        )
        return elbow_circle_rates(arm, q, velocity, elbow)

    return integrated_motion(law, trajectory, rates, lambda _: Scale(1.0, 1.0, 0.0), end)


def _is_near_another(arm: Dimensions, path: AxisPath, through: str) -> bool:
    """Return whether a circle passes the wrist's, or the elbow's circle the axis of q1, nearby."""
    q = path.joints(path.knots)
    wrist = float(np.abs(np.sin(q[:, 4])).min())
    c, _ = np.abs([wrist_in_plane(arm, q2, q3) for q2, q3 in q[:, 1:3].tolist()]).min(axis=0)
    return wrist < _NEAR_ANOTHER or (through == "elbow" and c < _NEAR_ANOTHER)


def _at_full_speed(
    law: AnyArmLaw, trajectory: Trajectory, path: AxisPath, end: MotionEnd
) -> Motion:
    """Yield a path at its nominal speed, whatever the joints need for it."""
    count = math.ceil(trajectory.duration / law.period - 1e-9)
    t = law.period * np.arange(count, dtype=np.float64)
    s = path.places(t)
    rates = path.joints(s, 1) / path.way(s, 1)[:, :1]
    rows = zip(t.tolist(), path.joints(s).tolist(), rates.tolist(), strict=True)
    for at, q, rate in rows:
        yield Sample(tuple(q), tuple(rate), 1.0, 1.0, trajectory.twist(at))
    last = tuple(path.joints(np.array([path.length]))[0].tolist())
    yield Sample(last, AT_REST, 0.0, 0.0, trajectory.twist(trajectory.duration))
    end.duration = trajectory.duration


def integrated_motion(
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


def unknown_path(law: str, trajectory: Trajectory) -> InfeasibleMotion:
    """Return the refusal of a path of another kind."""
    what = _KINDS.get(type(trajectory).__name__, "this path")
    return InfeasibleMotion(
        f"{law} plans lines and circles through a singularity, and not {what}; inverse, "
        "dls and servo-halt follow any path, esc a turn as well, and look-ahead a turn and one "
        "through given places."
    )
