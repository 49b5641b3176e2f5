"""The enhanced singularity-consistent law: as the paper has it, and with what it lacks."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal

from annotated_types import Ge, Interval, Unit

from controllers.arm.axis_path import axis_path_of_line
from controllers.arm.circular_trajectory import CircularTrajectory
from controllers.arm.decomposition import Scale, joint_rates, wrist_turning
from controllers.arm.geometry import ArmGeometry
from controllers.arm.integration import LONGEST_STEP
from controllers.arm.kinematics import singularity_indices
from controllers.arm.law import ArmLaw, Motion, MotionEnd, collected
from controllers.arm.motions import (
    circle_motion,
    dwell_motion,
    integrated_motion,
    unknown_path,
)
from controllers.arm.online.follower import OnDirection, TwistFollower
from controllers.arm.plan import Sample
from controllers.arm.promises import ALL_JOINTS, Promises
from controllers.arm.ramps import from_rest
from controllers.arm.region import (
    elbow_scale,
    pass_scale,
    region_for_acceleration,
    region_for_speed,
    region_for_twist,
)
from controllers.arm.retiming import follow_axis_path, retime_within
from controllers.arm.trajectories import StraightTrajectory
from controllers.arm.trajectory import Trajectory
from controllers.arm.turn_back import (
    TOUCHING,
    Slowing,
    check_turn_back,
    radial_share,
    turn_back,
)
from controllers.arm.turn_path import TurnTrajectory
from controllers.arm.types import AT_REST, Joints
from controllers.motion import InfeasibleMotion

Share = Annotated[float, Interval(gt=0.0, le=1.0)]

_ELBOW = 2
"""The place of q3 among the joints."""
_WIDEST = 0.3
"""Half width of the wrist's region, sine of q5: farther away nothing is singular."""
_STALLED = 1e-6
"""Share of its speed below which the hand does not get away from a singularity."""
_FINEST, _SMOOTH = 8, 2.5e-4
"""Samples in a period of a motion that is given ramps, at most; and the way of a joint from one to
the next, rad, with which there are enough."""
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
    elbow_region, wrist_region : float, optional
        Half widths of the regions of turning back and of passing the wrist's singularity: sines
        of q3 and q5. None: eq. (13), and for the wrist what its rates need. The wrist's may be 0.
    shoulder_region : float, optional
        The same of the shoulder's, distance c of the wrist from the axis of q1, m.
    """

    dwell_integral: Literal["taylor", "exact"] = "taylor"
    dwell_slope: Literal["zero", "natural"] = "zero"
    elbow_region: Share | None = None
    shoulder_region: Annotated[float, Unit("m"), Ge(0)] | None = None
    wrist_region: Annotated[float, Interval(ge=0.0, le=1.0)] | None = None


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
            return circle_motion(self, trajectory, end)
        if not isinstance(trajectory, StraightTrajectory):
            raise unknown_path(self.name, trajectory)
        if trajectory.depth is not None:
            settings = self.settings
            return dwell_motion(
                self,
                trajectory,
                end,
                settings.dwell_integral,
                "quintic",
                natural=settings.dwell_slope == "natural",
            )
        sin_qs = self.region(trajectory)
        if not trajectory.turns_back:
            return self._line(trajectory, sin_qs, end)
        elbow = trajectory.start[2] + self.arm.elbow_angle
        if math.sin(elbow) < -TOUCHING:
            raise InfeasibleMotion(
                f"q3 = {trajectory.start[2]:.4f} rad: with S3 < 0 the paper's b_v is -1 and the "
                f"hand would go against its command; start with q3 > 0, or take the law esc."
            )
        check_turn_back(self.geometry, self.arm, trajectory, self.region)
        slow = self._passing(trajectory, sin_qs)
        return turn_back(self.arm, trajectory, sin_qs, 1.0, slow, self.period, end)

    def region(self, trajectory: StraightTrajectory) -> float:
        """Return sin q_s for a line."""
        eq13 = region_for_speed(self.geometry, trajectory.speed)
        return _chosen(self.settings.elbow_region, eq13)

    def _passing(self, trajectory: StraightTrajectory, sin_qs: float) -> Slowing:
        """Return ``|b_s| |b_w|`` of a motion that turns back.

        Notes
        -----
        Each is there if a joint would pass its limit without it; its region is then as wide as
        keeps that limit where most is asked across the singularity, the wrist's no wider than
        `_WIDEST`. Both are looked for on the way of the law that slows no more than it has to.
        """
        arm, settings = self.arm, self.settings
        first, _, _, fourth, _, sixth = self.geometry.rate_limits
        c_s = s5_s = shoulder = wrist = 0.0
        slow = within_limits(self.geometry)
        for sample in turn_back(arm, trajectory, sin_qs, 1.0, slow, LONGEST_STEP, MotionEnd()):
            q = sample.positions
            scale = elbow_scale(q[2] + arm.elbow_angle, sin_qs, 1.0)
            plain = joint_rates(arm, q, *trajectory.command, scale)
            c, _, s5 = singularity_indices(arm, q)
            c_s = max(c_s, 1.5 * abs(c * plain[0]) / first)
            s5_s = max(s5_s, 1.5 * abs(s5 * plain[5]) / min(fourth, sixth))
            shoulder = max(shoulder, abs(plain[0]) / first)
            wrist = max(wrist, abs(plain[3]) / fourth, abs(plain[5]) / sixth)
        c_s = _chosen(settings.shoulder_region, c_s if shoulder > 1.0 else 0.0)
        s5_s = _chosen(settings.wrist_region, min(s5_s, _WIDEST) if wrist > 1.0 else 0.0)

        c, _, s5 = singularity_indices(arm, trajectory.start)
        if pass_scale(c, c_s) * pass_scale(s5, s5_s) < _STALLED:
            raise InfeasibleMotion(
                "the arm starts at the singularity of its shoulder or its wrist, where the paper's "
                "|b_s| or |b_w| is 0: it would never move. Start beside it, or take the law esc."
            )
        return Slowing(c_s, s5_s, AT_REST)

    def _line(self, trajectory: StraightTrajectory, sin_qs: float, end: MotionEnd) -> Motion:
        """Yield a line past singularities inside the workspace, ``|b|`` for each of them.

        The whole twist is scaled with the product: scaling the wrist's chain alone would not
        keep the commanded direction.
        """
        arm, limits = self.arm, self.geometry.rate_limits
        side = 1.0 if math.sin(trajectory.start[2] + arm.elbow_angle) > 0.0 else -1.0
        c_s = _chosen(self.settings.shoulder_region, 1.5 * trajectory.speed / limits[0])
        widest = 1.5 * self._greatest_turning(trajectory) / min(limits[3], limits[5])
        s5_s = _chosen(self.settings.wrist_region, widest)
        linear, angular = trajectory.command

        def scale_at(q: Joints) -> Scale:
            c, _, s5 = singularity_indices(arm, q)
            share = pass_scale(c, c_s) * pass_scale(s5, s5_s)
            b, square, per_elbow = elbow_scale(q[2] + arm.elbow_angle, sin_qs, side)
            return Scale(share * b, share * square, share * per_elbow)

        def rates(_: float, q: Joints) -> Joints:
            return joint_rates(arm, q, linear, angular, scale_at(q))

        return integrated_motion(self, trajectory, rates, scale_at, end)

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
    elbow_region : float, optional
        Its half width, sine of q3, whatever follows from the other two.
    from_rest : bool
        Begin and end at rest, by ramps within the joints' accelerations; between them the law's
        own are what they are. Otherwise the hand starts and stops at its speed within a period,
        as the paper's does.
    """

    account_turning: bool = True
    limit_acceleration: bool = True
    elbow_region: Share | None = None
    from_rest: bool = False


class Esc(ArmLaw[EscSettings]):
    """The paper's law with what it lacks.

    Promises: the hand stays on its path; no joint exceeds its rate limit, at the elbow also while
    the tool turns; q3 keeps its acceleration limit on a radial line to the boundary; the command's
    sign is kept on either side of the elbow; exact hits of shoulder and wrist are passed, and
    near misses take no longer than the rate limits require; a dwell has its exact length and
    never stops. Does not promise the accelerations of near misses nor, unless it is told to begin
    from rest, of its start and its stop: see `look-ahead`. Nor that it turns back on a line that
    meets the boundary across the arm's direction while the tool's turning pushes the wrist
    outward: the plan's outcome then is ``"stalls"``, see the notes.

    Notes
    -----
    Near the boundary the wrist is ``k S3^2`` inside of it and ``b = n S3``, so that the twist
    ``(b v, b^2 w)`` gives ``2 k S3' = -n v_r - n^2 o S3`` with the line's radial speed ``v_r`` and
    the outward speed ``o`` of the turning, and ``v_r' = n S3 c`` with ``c > 0`` on any straight
    line. The rest at ``S3 = v_r = 0`` has the trace ``-n^2 o / 2k`` and the determinant
    ``n^2 c / 2k``: with ``o > 0`` it attracts from both sides of the elbow, whatever the region's
    width, which is in n alone. A tool that does not turn lets the hand pass.

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
            and self.arm.offset == 0.0
            and self.settings.limit_acceleration
            and radial_share(self.arm, trajectory.start, trajectory.direction) > _RADIAL
        ):
            return self.promises
        return self.promises._replace(accelerations=(_ELBOW,))

    def region(self, trajectory: StraightTrajectory) -> float:
        """Return sin q_s for a line."""
        if self.settings.elbow_region is not None:
            return self.settings.elbow_region
        turning = trajectory.turn_rate if self.settings.account_turning else 0.0
        sin_qs = region_for_twist(self.geometry, trajectory.speed, turning)
        return max(sin_qs, self._slow_region(trajectory))

    def _slow_region(self, trajectory: StraightTrajectory) -> float:
        """Return what of it the accelerations ask for, however fast joints may be."""
        if not self.settings.limit_acceleration:
            return 0.0
        return region_for_acceleration(self.geometry, trajectory.speed)

    def follower(
        self, geometry: ArmGeometry, *, through: bool, rest: int | None = None
    ) -> TwistFollower:
        """Return what keeps the hand on the directions that it is asked for."""
        return OnDirection(geometry, self.period, through=through, rest=rest)

    def move(self, trajectory: Trajectory, end: MotionEnd) -> Motion:
        """Yield a sample per period."""
        if not self.settings.from_rest:
            return self._at_speed(trajectory, end)
        motion, fine = self._sampled(trajectory, end)
        limits = self.geometry.acceleration_limits
        path, timing = from_rest(motion, fine, self.period, end, limits)
        return follow_axis_path(trajectory, path, timing, self.period, end)

    def _sampled(self, trajectory: Trajectory, end: MotionEnd) -> tuple[list[Sample], float]:
        """Return the motion at its speed, and how far apart its samples are, s.

        A slow one has as many as it needs: eight in a period are twenty seconds' work.
        """
        settings, count = replace(self.settings, from_rest=False), 1
        while True:
            fine = self.period / count
            at_speed = Esc(settings, self.geometry, fine)
            at_speed.longest = self.longest
            motion = collected(at_speed.move(trajectory, end), fine, self.longest)
            longest = fine * max(abs(v) for sample in motion for v in sample.velocities)
            if count == _FINEST or longest <= _SMOOTH:
                return motion, fine
            count = min(_FINEST, count * math.ceil(longest / _SMOOTH))

    def _at_speed(self, trajectory: Trajectory, end: MotionEnd) -> Motion:
        """Yield the motion that is at its speed from the first instant to the last."""
        if isinstance(trajectory, CircularTrajectory):
            return circle_motion(self, trajectory, end)
        if isinstance(trajectory, TurnTrajectory):
            return self._one_way(trajectory, end)
        if not isinstance(trajectory, StraightTrajectory):
            raise unknown_path(self.name, trajectory)
        if trajectory.depth is not None:
            return dwell_motion(self, trajectory, end, "exact", "ramp", natural=True)
        if not trajectory.turns_back:
            return self._one_way(trajectory, end)
        sin_qs = self.region(trajectory)
        slowest = self._slow_region(trajectory)
        check_turn_back(self.geometry, self.arm, trajectory, self.region, slowest)
        side = 1.0 if math.sin(trajectory.start[2] + self.arm.elbow_angle) > 0.0 else -1.0
        slow = within_limits(self.geometry)
        return turn_back(self.arm, trajectory, sin_qs, side, slow, self.period, end)

    def _one_way(self, trajectory: Trajectory, end: MotionEnd) -> Motion:
        """Return a path that is gone once, as fast as the joints' rates allow."""
        path = axis_path_of_line(self.arm, trajectory)
        limits = self.geometry.rate_limits
        timing = retime_within(path, limits, None, self.period, None, self.longest)
        return follow_axis_path(trajectory, path, timing, self.period, end)


def within_limits(geometry: ArmGeometry) -> Slowing:
    """Return by what all rates are slowed so that none passes its limit."""
    q1, q2, q3, q4, q5, q6 = (1.0 / limit for limit in geometry.rate_limits)
    return Slowing(0.0, 0.0, (q1, q2, q3, q4, q5, q6))


def _chosen(number: float | None, otherwise: float) -> float:
    return otherwise if number is None else number
