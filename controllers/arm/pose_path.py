"""A path of the hand through given places: written in the experiment, or in a file.

The places are joined by a spline, on which the hand's nominal speed is constant. The law goes
through wrist and shoulder as on a line; see `look-ahead`.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from operator import add
from pathlib import Path
from typing import Annotated

from annotated_types import Gt, Unit

from controllers.arm.dynamics.settings import Payload
from controllers.arm.geometry import SixAngles
from controllers.arm.kinematics import Dimensions, forward
from controllers.arm.places.frames import Place, TaughtFrame, frame_called
from controllers.arm.places.poses import Poses, read_poses
from controllers.arm.trajectory import ArmPath, Trajectory
from controllers.arm.types import Joints, Pose
from controllers.motion import InfeasibleMotion

_BASE, _START = "base", "start"
_APART = 1e-9
"""Distance of two places that are one after the other, m; nearer ones are one place to any arm."""
_NEAR = (0.0, math.radians(20.0), math.radians(90.0), 0.0, math.radians(30.0), 0.0)


@dataclass(frozen=True, slots=True)
class PosePath(ArmPath):
    """A spline through places of the tool point, once from the first to the last.

    Parameters
    ----------
    file : Path, optional
        A CSV or YAML file: a header with ``x (mm), y (mm), z (mm)`` in any unit of length and, if
        the tool turns, its rotation or its direction; a row for each place. See `read_poses`.
    points : tuple of tuple of float
        Instead of a file: places, m; the tool keeps its direction.
    frame : str or TaughtFrame
        In whose axes places and rotations are. ``base``; ``start``: the tool's as it is at `near`;
        the name of one of the rig's `frames`; or a frame that is given here.
    near : tuple of float
        Joints near which the path begins, rad: they say which of the arm's branches it takes, and
        how the tool points if no rotation is given. Where a joint would leave its range that it
        keeps a whole turn away or on another branch, the path begins there.
    begin : tuple of float, optional
        Joints near which it begins instead, rad: another branch, while all that `near` says of
        frame and tool stays.
    speed : float
        Of the hand at most, m/s.
    payload : Payload
        What the hand carries: weight and inertia for the drives.
    torques : bool
        Whether the drives' torques are kept as well, as the arm's `dynamics` say them:
        `look-ahead` times the path under them, and under another law it is refused, with a speed
        that fits, if one needs more.
    """

    file: Path | None = None
    points: tuple[Place, ...] = ()
    frame: str | TaughtFrame = _BASE
    near: SixAngles = _NEAR
    begin: SixAngles | None = None
    speed: Annotated[float, Unit("m/s"), Gt(0)] = 0.1
    payload: Payload = Payload()  # noqa: RUF009  (frozen)
    torques: bool = False

    def __post_init__(self) -> None:
        if (self.file is not None) == bool(self.points):
            raise ValueError("give a file or points, and not both.")

    def turned(self, turns: Joints) -> "PosePath":
        """Return the same path, begun with joints that are whole turns (rad) away."""
        q1, q2, q3, q4, q5, q6 = map(add, self.near, turns)
        near = (q1, q2, q3, q4, q5, q6)
        if self.begin is None:
            return replace(self, near=near)
        b1, b2, b3, b4, b5, b6 = map(add, self.begin, turns)
        return replace(self, near=near, begin=(b1, b2, b3, b4, b5, b6))

    def seen_in(self, frames: Mapping[str, TaughtFrame]) -> "PosePath":
        """Return the same path with one of a rig's frames, if it names one.

        Raises
        ------
        InfeasibleMotion
            It names one that the rig has not.
        """
        if isinstance(self.frame, TaughtFrame) or self.frame in (_BASE, _START):
            return self
        return replace(self, frame=frame_called(self.frame, frames))

    def trajectory(self, arm: Dimensions) -> Trajectory:
        """Return the path; see `ArmPath`.

        Raises
        ------
        InfeasibleMotion
            The file cannot be read, or there is no path through its places.
        """
        from controllers.arm.pose_trajectory import PoseTrajectory

        poses = read_poses(Path(self.file)) if self.file else Poses(list(self.points))
        for number, (before, after) in enumerate(pairwise(poses.places), 1):
            away = math.dist(before, after)
            if away < _APART:
                raise InfeasibleMotion(_too_close(poses, number, away))
        if len(poses.places) < 2:
            raise InfeasibleMotion(
                f"{f'{poses.source}: ' if poses.source else ''}a path needs two places at least; "
                f"there is {len(poses.places)}."
            )
        carried = self.payload if self.torques else None
        return PoseTrajectory(
            arm, poses, self._frame(arm), self.near, self.begin or self.near, self.speed, carried
        )

    def _frame(self, arm: Dimensions) -> Pose | None:
        """Return the pose of the frame in the base; None: it is the base's own."""
        if self.frame == _BASE:
            return None
        if self.frame == _START:
            return forward(arm, self.near)
        if isinstance(self.frame, TaughtFrame):
            return Pose(self.frame.origin, self.frame.axes)
        return self.seen_in({})._frame(arm)


def _too_close(poses: Poses, number: int, away: float) -> str:
    """Return why a path does not lead from a place to the next; `number` of it, from 0."""
    same = f"{poses.where(number)} is place {number} again"
    if away > 0.0:
        same += f", {1e3 * away:.2g} mm away; {1e3 * _APART:g} mm are the least"
    if not poses.turns(number):
        return f"{same}."
    return (
        f"{same}, and the tool is turned there. The hand's speed times such a path, and a turn in "
        f"place has no length: write it as arm-turn without a centre, or move the place."
    )
