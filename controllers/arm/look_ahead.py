"""The path known ahead: as fast as the joints' rates and accelerations allow."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np
from annotated_types import Gt, Le

from controllers.arm.axis_path import FINEST, AxisPath, axis_path_of_line
from controllers.arm.circular_trajectory import CircularTrajectory
from controllers.arm.dynamics.carried import check_held, torques_for
from controllers.arm.dynamics.settings import Payload
from controllers.arm.esc import Esc, EscSettings
from controllers.arm.kinematics import forward
from controllers.arm.law import ArmLaw, Motion, MotionEnd, collected
from controllers.arm.motion_path import axis_path_of_motion, timed_samples
from controllers.arm.plan import ArmPlan, RangeWatch, Sample
from controllers.arm.promises import ALL_JOINTS, Promises
from controllers.arm.retiming import Timing, follow_axis_path, grid_of, retime_within
from controllers.arm.trajectories import ArmPathSettings, StraightTrajectory
from controllers.arm.trajectory import Trajectory
from controllers.arm.turn_path import TurnTrajectory
from controllers.motion import InfeasibleMotion

_SHORTEST = 0.125
"""Share of `_FINE` to which that period is shortened where the joints go fast."""
_FINE = 2e-3
"""Period at which a motion through the boundary is sampled for its joint path, s."""
_BRISK = 0.03
"""Speed at which a slower line that turns back is sampled, m/s: where the tool does not turn the
joints' path is the same at any speed."""
_SHARES = tuple(0.8**k for k in range(20))
"""Of the commanded speed that are tried until a turn-back fits."""


@dataclass(frozen=True, slots=True)
class LookAheadSettings:
    """Shares of the limits that are used.

    Parameters
    ----------
    rate_share, acceleration_share, torque_share : float
        Of the joints' limits; below 1 leaves room to the drives.
    """

    rate_share: Annotated[float, Gt(0), Le(1)] = 1.0
    acceleration_share: Annotated[float, Gt(0), Le(1)] = 1.0
    torque_share: Annotated[float, Gt(0), Le(1)] = 1.0


class LookAhead(ArmLaw[LookAheadSettings]):
    """The time-optimal way along the same path, from rest to rest.

    Promises: the hand stays on its path; no joint exceeds its rate or acceleration limit nor, if
    the path asks for it, the torque of its drive, nor the hand its speed; near misses and exact
    hits of shoulder and wrist take at most 1.10 times what the rate limits alone require, if
    torques are not looked at. At the boundary the elbow goes through as under `esc`, whose joint
    path it takes. Needs the whole path before it starts, and refuses a dwell: time is what it
    optimises.

    References
    ----------
    H. Pham and Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on
    Reachability Analysis", IEEE Transactions on Robotics 34(3), 2018.
    """

    Settings = LookAheadSettings
    name = "look-ahead"
    promises = Promises(rates=ALL_JOINTS, accelerations=ALL_JOINTS, path=True)

    _watch: RangeWatch | None = None

    def _planned_elsewhere(self, path: ArmPathSettings) -> ArmPlan:
        self._watch = RangeWatch(self.geometry)
        try:
            return self._planned(path)
        finally:
            self._watch = None

    def move(self, trajectory: Trajectory, end: MotionEnd) -> Motion:
        """Yield a sample per period."""
        if isinstance(trajectory, StraightTrajectory) and trajectory.depth is not None:
            raise InfeasibleMotion(
                f"look-ahead is as fast as it can be and cannot dwell {trajectory.dwell:g} s; "
                f"take esc or esc-paper."
            )
        path = self.axis_path(trajectory)
        timing = self.timing(path, trajectory)
        return follow_axis_path(trajectory, path, timing, self.period, end)

    def timing(self, path: AxisPath, trajectory: Trajectory) -> Timing:
        """Return when the joint path is where.

        Raises
        ------
        InfeasibleMotion
            The drives could not hold what the hand carries.
        """
        rates = [self.settings.rate_share * limit for limit in self.geometry.rate_limits]
        allowed = self.settings.acceleration_share * np.array(self.geometry.acceleration_limits)
        carried = carried_along(trajectory)
        torques = None
        if carried is not None:
            share = self.settings.torque_share
            torques, light = (
                torques_for(self.geometry, its, share) for its in (carried, Payload())
            )
            s, speed = grid_of(path), trajectory.speed
            check_held(
                torques, light, path.joints(s, 0), path.joints(s, 1),
                lambda k: speed * float(path.way(s[k : k + 1])[0, 0]),
            )  # fmt: skip
        return retime_within(path, rates, allowed, self.period, torques, self.longest)

    def axis_path(self, trajectory: Trajectory) -> AxisPath:
        """Return the joints along the path, whatever the time."""
        if isinstance(trajectory, StraightTrajectory) and not trajectory.turns_back:
            return axis_path_of_line(self.arm, trajectory)
        from controllers.arm.pose_trajectory import PoseTrajectory  # half a second, with scipy

        if isinstance(trajectory, PoseTrajectory | TurnTrajectory):
            return axis_path_of_line(self.arm, trajectory, watch=self._watch)
        if isinstance(trajectory, CircularTrajectory):
            return axis_path_of_line(self.arm, trajectory, trajectory.joints_at)
        trajectory, share = self._brisk(trajectory)
        period = _FINE
        samples, duration = self._fine(trajectory, period)
        longest = max(math.dist(a.positions, b.positions) for a, b in pairwise(samples))
        if longest > FINEST:
            period *= max(FINEST / longest, _SHORTEST)
            samples, duration = self._fine(trajectory, period)
        return axis_path_of_motion(*timed_samples(samples, period, duration), share)

    def _brisk(self, trajectory: Trajectory) -> tuple[Trajectory, float]:
        """Return a path at a speed at which it is sampled, and that speed over its own."""
        share = 1.0
        if isinstance(trajectory, StraightTrajectory):
            if trajectory.turn_rate == 0.0 and trajectory.speed < _BRISK:
                share = _BRISK / trajectory.speed
            share *= self._share_with_region(trajectory.slower(share))
            return trajectory.slower(share), share
        return trajectory, share

    def _share_with_region(self, trajectory: StraightTrajectory) -> float:
        """Return the share of a line's speed at which `esc` turns back on it, from where it starts.

        Slower it needs a narrower region, and the joints' path is the same; how fast it is
        followed is found afterwards.
        """
        esc = Esc(EscSettings(), self.geometry, _FINE)
        widest = abs(math.sin(trajectory.start[2] + self.arm.elbow_angle))
        for share in _SHARES:
            if esc.region(trajectory.slower(share)) < widest:
                return share
        return 1.0

    def _fine(self, trajectory: Trajectory, period: float) -> tuple[list[Sample], float]:
        """Return the motion of `esc` along the same path, and how long it takes, s.

        Raises
        ------
        InfeasibleMotion
            It does not come to the path's end: what is left of the path must not be left out.
        """
        esc, end = Esc(EscSettings(), self.geometry, period), MotionEnd()
        samples = collected(esc.move(trajectory, end), period, self.longest)
        if end.outcome != "done":
            gone = math.dist(*(forward(self.arm, samples[k].positions).position for k in (0, -1)))
            raise InfeasibleMotion(
                f"the joints' path is that of esc, which stalls {gone:.4g} m from the start: it "
                f"does not turn back at the boundary from there, where the tool's turning pushes "
                f"the wrist outward; start the line elsewhere, or do not turn the tool on it "
                f"(turn_rate: 0)."
            )
        return samples, end.duration


def carried_along(trajectory: Trajectory) -> Payload | None:
    """Return what a path has the drives carry within their torques, None if it does not ask."""
    from controllers.arm.pose_trajectory import PoseTrajectory  # half a second, with scipy

    return trajectory.carried if isinstance(trajectory, PoseTrajectory) else None
