"""Motions that turn back at the boundary: through the region, or dwelling in it."""

import math
from collections.abc import Callable
from typing import NamedTuple

from controllers.arm.decomposition import Scale, elbow_frame, joint_rates
from controllers.arm.dwell import QuinticDwell, RampDwell, integral_exact
from controllers.arm.geometry import ArmGeometry
from controllers.arm.integration import LONGEST_STEP, ROUNDS, advance_joints, between, moved
from controllers.arm.kinematics import Dimensions, singularity_indices, wrist_centre
from controllers.arm.law import AnyArmLaw, Motion, MotionEnd
from controllers.arm.plan import Sample, inside_boundary
from controllers.arm.region import elbow_scale, least_rate
from controllers.arm.trajectories import StraightTrajectory
from controllers.arm.turn_back_kernel import TurnNumbers, TurnSample, turn_on, turn_sample
from controllers.arm.types import AT_REST, Joints, Twist, Vector
from controllers.bisection import bisect
from controllers.compiled import KernelMemory
from controllers.motion import InfeasibleMotion, check_length
from controllers.rounding import floor

TOUCHING = 1e-6
"""Index, as it is (sine, or m), below which an arm is said to be at a singularity."""
_TANGENTIAL = 1e-3
_A_LITTLE = 1e-3
"""s."""
_SLOWEST = 1e-6
"""Share of a line's speed below which no region is looked for."""
_ROUNDED = 0.995
"""Share of two speeds that are said in four digits each: a line that is given by where it touches
starts elsewhere if their ratio is another."""
_SMOOTH = 1e-3
"""Way of a joint in one step of integration within which samples may be interpolated, rad: the
joints then are right to a nanoradian."""
_AT_REST = 1e-6
"""rad/s."""


def check_turn_back(
    geometry: ArmGeometry,
    arm: Dimensions,
    trajectory: StraightTrajectory,
    region: Callable[[StraightTrajectory], float],
    whatever_rate: float = 0.0,
) -> None:
    """Raise if a line cannot be turned back on within a region.

    Parameters
    ----------
    geometry, arm
        The arm.
    trajectory : StraightTrajectory
        The line.
    region : callable
        Takes a line and returns the half width that it needs, sin q_s; not less at more speed.
    whatever_rate : float
        What it needs of that however fast q3 may be.

    Raises
    ------
    InfeasibleMotion
        No region is wide enough, or the arm starts in it; at its singularity, along the boundary;
        at the shoulder's or the wrist's singularity.
    """
    elbow = trajectory.start[2] + arm.elbow_angle
    s3 = math.sin(elbow)
    if abs(s3) < TOUCHING and math.cos(elbow) > 0.0:
        share = abs(radial_share(arm, trajectory.start, trajectory.direction))
        kind = (
            f"tangential to the boundary (its radial share is {share:.2g}): b stays 0 and the arm "
            f"never moves"
            if share < _TANGENTIAL
            else "from the boundary itself, on no side of the elbow that a sign could be kept of"
        )
        raise InfeasibleMotion(
            f"the arm starts at the elbow's singularity (S3 = {s3:.2g}) and the command is {kind}."
        )
    if abs(s3) < TOUCHING:
        raise InfeasibleMotion(
            f"the arm starts folded (S3 = {s3:.2g}), on no side of the elbow that a sign could be "
            f"kept of."
        )
    sin_qs = region(trajectory)
    # Before the region: it names a speed, and at no speed may the arm start there.
    side = math.copysign(1.0, s3)
    check_start(arm, trajectory, elbow_scale(elbow, min(sin_qs, 1.0), side))
    widest = abs(s3) if math.cos(elbow) > 0.0 else 1.0  # the start has to be outside of it
    if sin_qs > 1.0:
        limit = geometry.rate_limits[2]
        least = max(limit * sin_qs, least_rate(geometry, trajectory.speed)) / widest
        slower = ". The hand would have to be"
        helps = ""
        if whatever_rate < widest:
            helps = f". q3 would need at least {math.ceil(1e4 * least) / 1e4:.4f} rad/s"
            slower = ", or the hand be"
        raise InfeasibleMotion(
            f"at {trajectory.speed:g} m/s and {limit:g} rad/s of q3 eq. (13) gives sin q_s = "
            f"{sin_qs:.4f}, more than 1: there is no such region{helps}"
            f"{_no_faster(trajectory, region, widest, slower)}."
        )
    if sin_qs >= widest and math.cos(elbow) > 0.0:
        raise InfeasibleMotion(
            f"the arm starts inside the region: |S3| = {abs(s3):.4f} at the start, no more than "
            f"sin q_s = {sin_qs:.4f}; its speed would begin with a step"
            f"{_no_faster(trajectory, region, widest, '. It would not, should the hand be')}."
        )


def _no_faster(
    trajectory: StraightTrajectory,
    region: Callable[[StraightTrajectory], float],
    widest: float,
    lead: str,
) -> str:
    """Say how fast the hand may be for a region that is narrow enough; nothing if none is."""

    def fits(share: float) -> bool:
        return region(trajectory.slower(share)) < widest

    if not fits(_SLOWEST):
        return ""
    share, _ = bisect(fits, _SLOWEST, 1.0)
    if trajectory.turn_rate:
        share *= _ROUNDED
    words = f"{lead} no faster than {floor(share * trajectory.speed):g} m/s"
    if trajectory.turn_rate:
        words += f" and turn no faster than {floor(share * trajectory.turn_rate):g} rad/s"
    return words


def check_start(arm: Dimensions, trajectory: StraightTrajectory, scale: Scale) -> None:
    """Raise if the arm starts at the shoulder's or the wrist's singularity and has to turn there.

    A command that asks nothing of the singular joint, there and a little later, is no reason.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    trajectory : StraightTrajectory
        The line.
    scale : Scale
        Of the twist at the start.

    Raises
    ------
    InfeasibleMotion
        With the index and the joint.
    """
    q = trajectory.start
    c, _, s5 = singularity_indices(arm, q)
    rates = joint_rates(arm, q, *trajectory.command, scale)
    after = joint_rates(arm, moved(q, rates, _A_LITTLE), *trajectory.command, scale)
    for index, name, unit, joint in ((c, "shoulder", " m", 0), (s5, "wrist", "", 5)):
        greatest = max(abs(rates[joint]), abs(after[joint]))
        if abs(index) < TOUCHING and greatest > _AT_REST:
            symbol = "c" if joint == 0 else "S5"
            raise InfeasibleMotion(
                f"the arm starts at the {name}'s singularity ({symbol} = {index:.2g}{unit}) and "
                f"the command asks q{joint + 1} to turn there: it would have to jump. Start with "
                f"|{symbol}| of more than {TOUCHING:g}{unit}."
            )


def radial_share(arm: Dimensions, q: Joints, direction: Vector) -> float:
    """Return how far the wrist gets away from the shoulder per metre in a direction.

    The cosine between it and the wrist's; with a shoulder offset up to ``sqrt(1 + d² / r_s²)``.
    """
    sine, cosine, radius, _ = elbow_frame(arm, q[1], q[2])
    c1, s1 = math.cos(q[0]), math.sin(q[0])
    ahead = direction[0] * c1 + direction[1] * s1
    c = radius * sine + arm.a1
    if arm.offset != 0.0 and c != 0.0:  # then q1 moves the wrist within the arm's plane, too
        ahead += arm.offset * (direction[1] * c1 - direction[0] * s1) / c
    return sine * ahead + cosine * direction[2]


class Slowing(NamedTuple):
    """A factor on all rates beyond that of the elbow's region: a change of time.

    Parameters
    ----------
    shoulder, wrist : float
        Half widths of the regions around these singularities, m and sine of q5; 0: none.
    per_limit : tuple of float
        1 over the rate limits that are kept, s/rad; 0: none.
    """

    shoulder: float
    wrist: float
    per_limit: Joints


def turn_back(
    arm: Dimensions,
    trajectory: StraightTrajectory,
    sin_qs: float,
    side: float,
    slow: Slowing,
    period: float,
    end: MotionEnd,
) -> Motion:
    """Yield the motion out, through the elbow's singularity, and back to the start.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    trajectory : StraightTrajectory
        The line.
    sin_qs : float
        Half width of the region.
    side : float
        The elbow's, when it starts.
    slow : Slowing
        Beyond the region's scale.
    period : float
        s.
    end : MotionEnd
        Is filled in.

    References
    ----------
    Miyata et al., eq. (6), (11), (13).
    """
    origin = trajectory.pose(0.0).position
    linear, angular = trajectory.command
    numbers = TurnNumbers(
        *arm, linear, angular, origin, trajectory.direction, sin_qs, side,
        slow.shoulder, slow.wrist, slow.per_limit,
    )  # fmt: skip
    memory = KernelMemory(numbers)
    at, on = memory.bind(turn_sample), memory.bind(turn_on)

    def sample(now: TurnSample) -> Sample:
        return Sample(now.joints, now.rates, now.linear, now.angular, trajectory.command)

    def instant(holds: Callable[[TurnSample], bool]) -> float:
        """Return how far into the period that begins now a condition stops to hold, s."""
        low, high = bisect(lambda into: holds(on(*now[:2], into)), 0.0, period, ROUNDS)
        return 0.5 * (low + high)

    t, now = 0.0, at(trajectory.start)
    borders: list[float] = []
    longest = 20.0 * trajectory.duration
    yield sample(now)
    while t < longest:
        after = on(now.joints, now.rates, period)
        if after.inside != now.inside:
            stays = (lambda there: there.inside) if now.inside else (lambda there: not there.inside)
            borders.append(t + instant(stays))
        if after.distance <= 0.0:
            into = instant(lambda there: there.distance > 0.0)
            last = sample(on(now.joints, now.rates, into))
            yield last._replace(velocities=AT_REST, linear=0.0, angular=0.0)
            end.duration = t + into
            end.marks = {"region": tuple(borders)}
            return
        now, t = after, t + period
        yield sample(now)
    end.duration, end.outcome = t, "stalls"


def dwelling(
    arm: Dimensions,
    trajectory: StraightTrajectory,
    q_s: float,
    profile: QuinticDwell | RampDwell,
    law: AnyArmLaw,
    end: MotionEnd,
) -> Motion:
    """Yield the motion to the region, a dwell in it, and the way back.

    Within the region b is given over time; outside the hand keeps its speed.

    References
    ----------
    Miyata et al., eq. (14)-(16).
    """
    linear = trajectory.command.linear
    offset, a2a3 = arm.elbow_angle, arm.a2 * arm.a3
    side = 1.0 if math.sin(trajectory.start[2] + offset) >= 0.0 else -1.0
    still = (0.0, 0.0, 0.0)
    enter, leave, way_back = _dwell_instants(arm, trajectory, q_s, profile)

    def scale_at(t: float, q: Joints) -> Scale:
        if t < enter:
            return Scale(1.0, 1.0, 1.0 / math.sin(q[2] + offset))
        if t > leave:
            return Scale(-1.0, 1.0, -1.0 / math.sin(q[2] + offset))
        radial = trajectory.speed * radial_share(arm, q, trajectory.direction)
        per_elbow = side * profile.at(t - enter) * a2a3 / radial
        return Scale(per_elbow * math.sin(q[2] + offset), 1.0, per_elbow)

    def rates(t: float, q: Joints) -> Joints:
        return joint_rates(arm, q, linear, still, scale_at(t, q))

    def moved(now: Joints, q: Joints, t: float, until: float) -> Joints:
        """Go on, without a step across an instant at which b has a corner."""
        known: Joints | None = now
        for border in (enter, leave):
            if t < border < until:
                inner = border - 1e-12 if border == enter else border
                q = advance_joints(rates, t, q, inner - t, known)
                t, known = border + (1e-12 if border == leave else 0.0), None
        return advance_joints(rates, t, q, until - t, known)

    finish, period = leave + way_back, law.period
    check_length(finish, law.longest)
    q, t = trajectory.start, 0.0
    command = Twist(linear, still)
    borders = (enter, leave, finish)

    def sample(t: float, q: Joints) -> Sample:
        scale = scale_at(t, q)
        return Sample(q, joint_rates(arm, q, linear, still, scale), scale.linear, 1.0, command)

    while t < finish:
        now = sample(t, q)
        yield now
        stride = _stride(now.velocities, period)
        if stride == 1 or any(t < border <= t + stride * period for border in borders):
            q, t = moved(now.velocities, q, t, min(t + period, finish)), t + period
            continue
        # So slow that one step of the method spans several periods.
        whole = stride * period
        after = advance_joints(rates, t, q, whole, now.velocities)
        ends = (q, now.velocities, after, rates(t + whole, after))
        for k in range(1, stride):
            yield sample(t + k * period, between(*ends, whole, k / stride))
        q, t = after, t + whole
    yield Sample(q, AT_REST, 0.0, 0.0, command)
    end.duration = finish
    end.marks = {"region": (enter, leave)}


def _stride(rates: Joints, period: float) -> int:
    """Return over how many periods (s) one step goes from joints at these rates, rad/s."""
    longest = min(LONGEST_STEP, _SMOOTH / max(*map(abs, rates), 1e-9))
    return max(1, math.floor(longest / period + 1e-9))


def _dwell_instants(
    arm: Dimensions,
    trajectory: StraightTrajectory,
    q_s: float,
    profile: QuinticDwell | RampDwell,
) -> tuple[float, float, float]:
    """Return when the region is entered and left, and how long the way back takes from there, s.

    The elbow's differential equation separates: the integral of b is that of ``dq3 / r_s``. A ramp
    has the one that the region takes. The Taylor expansion has a little more: the hand leaves when
    the elbow is at its border, sooner than t_s.
    """
    from scipy.optimize import brentq

    enter: float = time_at_depth(arm, trajectory, q_s)
    stay = profile.duration
    if isinstance(profile, QuinticDwell):
        needed = integral_exact(arm, q_s)
        if profile.covered(stay) - needed > 1e-10 * needed:
            stay = brentq(lambda t: profile.covered(t) - needed, 0.0, stay, xtol=1e-13)
    return enter, enter + stay, enter


def time_at_depth(arm: Dimensions, trajectory: StraightTrajectory, q_s: float) -> float:
    """Return the nominal time at which the elbow is at `q_s` on the way out, s.

    Raises
    ------
    InfeasibleMotion
        The arm starts beyond it.
    """
    square = arm.a2**2 + arm.a3**2 + 2.0 * arm.a2 * arm.a3 * math.cos(q_s)
    if arm.a1 != 0.0:
        depth = arm.a2 + arm.a3 - math.sqrt(square)
        _check_outside(inside_boundary(arm, trajectory.start), depth)
        return trajectory.time_at_radius(arm, math.sqrt(square))
    x, y, z = wrist_centre(arm, trajectory.start)
    z -= arm.height
    dx, dy, dz = trajectory.direction
    along = x * dx + y * dy + z * dz
    here = x * x + y * y + z * z - arm.offset**2
    if here >= square:
        reach = arm.a2 + arm.a3
        _check_outside(reach - math.sqrt(here), reach - math.sqrt(square))
    way: float = -along + math.sqrt(along * along + square - here)
    return way / trajectory.speed


def _check_outside(depth: float, region: float) -> None:
    """Raise if a wrist is no deeper inside the boundary than a region is, m."""
    if depth <= region:
        raise InfeasibleMotion(
            f"the arm starts inside the region: its wrist is {depth:.4f} m from the boundary, the "
            f"region is {region:.4f} m deep."
        )
