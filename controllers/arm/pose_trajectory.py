"""A spline through poses as a trajectory: nominal time is length over speed."""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from controllers.arm.dynamics.settings import Payload
from controllers.arm.inverse import BRANCHES, OutOfReach, branch_of, reachable
from controllers.arm.kinematics import Dimensions, forward
from controllers.arm.places.poses import Poses
from controllers.arm.places.turning import Constant, Pointed, Splined, ToolTurning
from controllers.arm.types import Joints, Pose, Twist, Vector
from controllers.motion import InfeasibleMotion

Array = NDArray[np.float64]

_SAMPLES = 4000
"""Of the spline, for its length."""
_HALVINGS = 12
"""How often the samples are halved, at most."""
_UNEVEN = 1e-5
"""By how much the hand's speed may differ from the path's, relative, beside its samples."""
_SAME = 1e-12
"""Share of the spline's parameter within which two of its places are one."""
_BETWEEN = 65
"""Places that are looked at between three samples."""
_ROUNDS = 4
"""Newton's, for the nearest place."""


class PoseTrajectory:
    """A spline through poses.

    Parameters
    ----------
    arm : Dimensions
        Of the arm.
    poses : Poses
        Places and how the tool stands there, as their frame sees them.
    frame : Pose, optional
        Of the frame in the base; None: the base's own.
    near, begin : tuple of float
        How the tool stands unless it is said, and near which joints the path begins, rad; see
        `PosePath`.
    speed : float
        Of the hand, m/s.
    carried : Payload, optional
        What the drives have to move within their torques; None: torques are not looked at.

    Raises
    ------
    InfeasibleMotion
        The arm does not reach its beginning.
    """

    def __init__(
        self,
        arm: Dimensions,
        poses: Poses,
        frame: Pose | None,
        near: Joints,
        begin: Joints,
        speed: float,
        carried: Payload | None = None,
    ) -> None:
        points = np.array(poses.places, dtype=np.float64)
        axes = np.eye(3)
        if frame is not None:
            axes = np.array(frame.rotation)
            points = points @ axes.T + np.array(frame.position)
        u = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
        self._given, self._poses = u, poses
        self._places = CubicSpline(u, points)
        self._turning = _turning(u, poses, axes, np.array(forward(arm, near).rotation))
        fine, lengths = self._measured(np.linspace(0.0, u[-1], _SAMPLES), u)
        self._fine, self._samples = fine, np.asarray(self._places(fine))
        self._spacing = float(np.linalg.norm(np.diff(self._samples, axis=0), axis=1).max())
        self.speed = speed
        self.duration = float(lengths[-1]) / speed
        self.turn_rate = max(
            float(np.linalg.norm(self.twist(t).angular))
            for t in np.linspace(0.0, self.duration, 200).tolist()
        )
        self.start = self._begin(arm, begin)
        self.carried = carried

    def _measured(self, even: Array, u: Array) -> tuple[Array, Array]:
        """Return places of the spline and its lengths up to them, close where it bends sharply.

        There the hand would not have its speed: halfway between two places that is looked at.
        """
        fine = _apart(np.unique(np.concatenate((even, u))))
        for _ in range(_HALVINGS):
            slopes = np.linalg.norm(self._places(fine, 1), axis=1)
            halfway = 0.5 * (fine[1:] + fine[:-1])
            middle = np.linalg.norm(self._places(halfway, 1), axis=1)
            pieces = np.diff(fine) * (slopes[1:] + 4.0 * middle + slopes[:-1]) / 6.0
            lengths = np.concatenate(([0.0], np.cumsum(pieces)))
            self._at = CubicSpline(lengths, fine)
            s = 0.5 * (lengths[1:] + lengths[:-1])
            speed = np.linalg.norm(self._places(self._at(s), 1), axis=1) * self._at(s, 1)
            loose = np.abs(speed - 1.0) > _UNEVEN
            if not loose.any():
                break
            fine = _apart(np.unique(np.concatenate((fine, halfway[loose]))))
        return self._at(lengths), lengths

    def pose(self, t: float) -> Pose:
        """Return the pose at a nominal time."""
        u = float(self._at(self.speed * t))
        x, y, z = self._places(u).tolist()
        first, second, third = (tuple(row) for row in self._turning.at(u).tolist())
        return Pose((x, y, z), (first, second, third))

    def twist(self, t: float) -> Twist:
        """Return the twist at a nominal time."""
        s = self.speed * t
        u, rate = float(self._at(s)), self.speed * float(self._at(s, 1))
        vx, vy, vz = (rate * self._places(u, 1)).tolist()
        wx, wy, wz = (rate * self._turning.rate(u)).tolist()
        return Twist((vx, vy, vz), (wx, wy, wz))

    def command_at(self, gone: float) -> Twist:
        """Return the twist at a nominal time: the path is not turned back on."""
        return self.twist(gone)

    def between(self, t: float) -> str:
        """Return between which places a nominal time is; see `ThroughPlaces`."""
        u = float(self._at(self.speed * min(t, self.duration)))
        before = int(np.clip(np.searchsorted(self._given, u) - 1, 0, len(self._given) - 2))
        said = f"between places {before + 1} and {before + 2}"
        if not self._poses.source:
            return said
        first, second = self._poses.lines[before : before + 2]
        return f"{said} (lines {first} and {second} of {self._poses.source})"

    def foot(self, position: Vector) -> Vector:
        """Return the nearest place of the path, m."""
        at = np.array(position)
        away = np.linalg.norm(self._samples - at, axis=1)
        wide = np.concatenate(([np.inf], away, [np.inf]))
        lowest = (away <= wide[:-2]) & (away <= wide[2:])
        # Where a path comes back close by, the nearest sample may be on the other way.
        near = np.flatnonzero(lowest & (away <= away.min() + self._spacing))
        feet = self._feet(at, near)
        x, y, z = feet[int(np.argmin(np.linalg.norm(feet - at, axis=1)))].tolist()
        return x, y, z

    def _feet(self, at: Array, near: NDArray[np.intp]) -> Array:
        """Return the nearest places about some samples, m, shape (n, 3).

        All at once: a path that goes to and fro over the same ground has many.
        """
        first = self._fine[np.maximum(near - 1, 0)]
        last = self._fine[np.minimum(near + 1, len(self._fine) - 1)]
        grid = np.linspace(first, last, _BETWEEN, axis=1)
        closest = np.argmin(np.linalg.norm(self._places(grid) - at, axis=2), axis=1)
        u = grid[np.arange(len(near)), closest]
        for _ in range(_ROUNDS):
            away, slope = self._places(u) - at, self._places(u, 1)
            curve = np.sum(slope * slope + away * self._places(u, 2), axis=1)
            step = np.sum(away * slope, axis=1) / np.where(curve > 0.0, curve, np.inf)
            nearer = np.clip(u - step, 0.0, float(self._places.x[-1]))
            # Next to where the path turns back Newton may go past the nearest place.
            past = np.linalg.norm(self._places(nearer) - at, axis=1) > np.linalg.norm(away, axis=1)
            u = np.where(past, u, nearer)
        return np.asarray(self._places(u), dtype=np.float64)

    def _begin(self, arm: Dimensions, near: Joints) -> Joints:
        pose = self.pose(0.0)
        elbow = branch_of(arm, near).elbow
        try:
            branches = [branch for branch in BRANCHES if branch.elbow == elbow]
            found = reachable(arm, pose, branches, near)
        except OutOfReach as error:
            raise InfeasibleMotion(
                f"the path cannot be begun: {error} ({self._poses.where(0)})."
            ) from error
        return min(found, key=lambda q: float(np.linalg.norm(np.subtract(q, near))))


def _apart(places: Array) -> Array:
    """Return increasing places without those that only rounding tells from the one before."""
    apart = np.concatenate(([True], np.diff(places) > _SAME * places[-1]))
    return np.asarray(places[apart], dtype=np.float64)


def _turning(u: Array, poses: Poses, axes: Array, tool: Array) -> ToolTurning:
    """Return how the tool turns; `axes` are the frame's in the base, `tool` stands at `near`."""
    try:
        return _turning_of(u, poses, axes, tool)
    except InfeasibleMotion as error:
        if not poses.source:
            raise
        raise InfeasibleMotion(f"{poses.source}: {error}") from error


def _turning_of(u: Array, poses: Poses, axes: Array, tool: Array) -> ToolTurning:
    if poses.quaternions is not None:
        return Splined(u, poses.quaternions, axes)
    if poses.directions is not None:
        directions = [tuple(axes @ direction) for direction in poses.directions]
        return Pointed(u, directions, poses.spins, tool)
    return Constant(tool)
