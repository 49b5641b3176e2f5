"""The least time that a path takes under the joints' rate limits: what laws are held against."""

from functools import lru_cache

from controllers.arm.dwell import elbow_at_depth
from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.retiming import velocity_limited_time
from controllers.arm.trajectories import ArmPathSettings, StraightTrajectory, make_trajectory
from controllers.arm.turn_back import time_at_depth


def least_time(geometry: ArmGeometry, path: ArmPathSettings) -> float:
    """Return the least time for a path, s, whatever accelerations it takes.

    The hand goes and turns no faster than commanded, no joint faster than its limit. A dwell
    takes the time that is asked for, and the line outside its region the time at full speed.

    Raises
    ------
    InfeasibleMotion
        The path cannot be followed through its singularity.
    """
    try:
        return _least_time(geometry, path)
    except TypeError:  # a list for a tuple: what it comes to cannot be remembered
        return _least_time.__wrapped__(geometry, path)


@lru_cache  # the same for every law that is held against it
def _least_time(geometry: ArmGeometry, path: ArmPathSettings) -> float:
    arm = dimensions_of(geometry)
    trajectory = make_trajectory(arm, path)
    if isinstance(trajectory, StraightTrajectory) and trajectory.depth is not None:
        outside = time_at_depth(arm, trajectory, elbow_at_depth(arm, trajectory.depth))
        return 2.0 * outside + trajectory.dwell
    law = LookAhead(LookAheadSettings(), geometry, 0.0)
    return velocity_limited_time(law.axis_path(trajectory), geometry.rate_limits)
