"""A path lifted to the joints: a smooth curve over its own length in joint space.

In that length the curve is regular where the path is not: at an exact hit of a singularity, where
the joints go on without a jump, and at the boundary, where the path itself stops.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from controllers.arm.inverse import BRANCHES, OutOfReach, nearest_turns, reachable, wrist_joints
from controllers.arm.kinematics import (
    Dimensions,
    forward,
    singularity_indices,
    wrist_in_plane,
)
from controllers.arm.reversals import with_reversals
from controllers.arm.singular_places import NEAR
from controllers.arm.trajectory import ThroughPlaces, Trajectory, where_on
from controllers.arm.types import Joints, Pose
from controllers.arm.vectors import rotation_error
from controllers.motion import InfeasibleMotion

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

Array = NDArray[np.float64]
Inverse = Callable[[float, Joints], list[Joints]]

FINEST = 4e-3
"""Greatest step of the joints between two samples, rad: the spline through them then misses the
path by less than 1e-9 m."""
_COARSEST = 200
_FEWEST = 40
"""Into so many steps a path is divided at least, however little the joints move on it."""
_SHORTEST = 1e-13
"""Share of the path below which a step is not divided any more: past two near misses at once, of
some µm, the joints swing within 1e-10 of it. An instant is known to 1e-16 of it."""
_SLIGHT = 1e-3
"""m: by so little a path is outside that was to touch the boundary."""
_HELD = (
    " Places that lie nearer together there, or a little further inside, hold the curve within; "
    "to the boundary itself and back lead arm-turnback, arm-dwell and arm-circle."
)
_LOOKED_AT = 500
"""Places of a path that leaves the workspace at which it is looked at by how much."""
_CLOSER = 3
"""How often, the last times closely about the place where it leaves farthest."""
_LEAVING = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
"""Shares of the path after which it is looked at how a singularity at its beginning is left."""
_REFINEMENTS = 24
"""How often steps are halved between which the path is left."""
_NEWTON = 3
"""Steps of Newton's method from a place that is interpolated between two samples."""
_LOOSE = 1e-7
"""Distance of the hand from its path halfway between two samples, m."""
_LOOSE_TURN = 1e-6
"""The same of the tool, rad."""
_UNDECIDED = 1e-7
"""A tool nearer to the forearm's direction than this has no q4 of its own, rad; a wrist nearer to
the axis of q1, m, has no q1."""


class AxisPath:
    """A curve through the six joints, with how far the hand has gone and turned along it.

    Parameters
    ----------
    joints : sequence
        Of each sample, rad.
    gone, turned : sequence of float
        Of each sample: the integrals over time of the scales of velocity and angular velocity,
        which is the nominal time where both are 1, s.
    reversals : sequence of float
        Those of `gone` at which the joints turn round: smooth on either side, they rest there.
    """

    def __init__(
        self,
        joints: Sequence[Joints],
        gone: Sequence[float],
        turned: Sequence[float],
        reversals: Sequence[float] = (),
    ) -> None:
        q, way = np.array(joints), np.column_stack((gone, turned))
        steps = np.linalg.norm(np.diff(q, axis=0), axis=1)
        keep = np.concatenate(([True], steps > 1e-12))
        q, way = q[keep], way[keep]
        lengths = np.linalg.norm(np.diff(q, axis=0), axis=1)
        self.knots: Array = np.concatenate(([0.0], np.cumsum(lengths)))
        corners = np.flatnonzero(np.isin(way[1:-1, 0], reversals)) + 1
        self.corners: Array = self.knots[corners]
        self._joints = _spline(self.knots, q, corners)
        self._way = _spline(self.knots, way, corners)

    @property
    def length(self) -> float:
        """In joint space, rad."""
        return float(self.knots[-1])

    def joints(self, s: Array, order: int = 0) -> Array:
        """Return the joints or a derivative by the length, shape (n, 6)."""
        return np.asarray(self._joints(s, order), dtype=np.float64)

    def way(self, s: Array, order: int = 0) -> Array:
        """Return how far the hand has gone and turned, s, or a derivative, shape (n, 2)."""
        return np.asarray(self._way(s, order), dtype=np.float64)

    def places(self, nominal: Array) -> Array:
        """Return the lengths (rad) at which so much nominal time has gone, s, shape (n,)."""
        s = np.interp(nominal, self.way(self.knots)[:, 0], self.knots)
        for _ in range(_NEWTON):
            s = np.clip(s - (self.way(s)[:, 0] - nominal) / self.way(s, 1)[:, 0], 0.0, self.length)
        return np.asarray(s, dtype=np.float64)

    def samples(self, count: int) -> Iterator[tuple[Joints, Joints]]:
        """Yield joints (rad) and their rates at nominal speed (rad/s), evenly along the length."""
        s = np.linspace(0.0, self.length, count)
        rates = self.joints(s, 1) / self.way(s, 1)[:, :1]
        for q, rate in zip(self.joints(s).tolist(), rates.tolist(), strict=True):
            yield tuple(q), tuple(rate)


def _spline(knots: Array, values: Array, corners: NDArray[np.intp]) -> "PPoly":
    """Return the splines through values, shape (n, m), from corner to corner, as one."""
    from scipy.interpolate import CubicSpline, PPoly

    ends = [0, *corners.tolist(), len(knots) - 1]
    pieces = [CubicSpline(knots[a : b + 1], values[a : b + 1]) for a, b in pairwise(ends)]
    return PPoly(np.concatenate([piece.c for piece in pieces], axis=1), knots)


def axis_path_of_line(
    arm: Dimensions,
    trajectory: Trajectory,
    joints_at: Inverse | None = None,
    watch: Callable[[Joints], None] | None = None,
) -> AxisPath:
    """Return the joints along a path that is gone once, through exact hits of shoulder and wrist.

    The branch is the one that goes on: through an exact hit c or S5 changes its sign, past a near
    miss q1 or q4 swings round.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    trajectory : Trajectory
        The path.
    joints_at : callable, optional
        From a nominal time (s) to all joints there (rad), turns nearest to the second argument;
        if the path is known better than by its poses. Otherwise S3 keeps its sign.
    watch : callable, optional
        Takes the joints of each sample (rad) as they are found; what it raises ends the search.

    Raises
    ------
    InfeasibleMotion
        The line leaves the workspace.
    """
    last = trajectory.duration
    step = last / _COARSEST
    elbow = 1 if math.sin(trajectory.start[2] + arm.elbow_angle) >= 0.0 else -1
    branches = [branch for branch in BRANCHES if branch.elbow == elbow]

    def reached(t: float, guess: Joints) -> list[Joints]:
        if joints_at is not None:
            return joints_at(t, guess)
        return reachable(arm, trajectory.pose(t), branches, guess)

    def solutions(t: float, guess: Joints) -> list[Joints]:
        try:
            return reached(t, guess)
        except OutOfReach as error:
            raise InfeasibleMotion(
                f"{_gone(trajectory, t)} the path leaves the workspace: {error}. "
                f"{_farthest(trajectory, t, error, reached)}"
            ) from error

    def solve(t: float, guess: Joints) -> Joints | None:
        found = solutions(t, guess)
        if t == last:
            found = [_decided(arm, trajectory.pose(t), q, guess) for q in found]
        best = min(found, key=lambda q: math.dist(q, guess))
        return None if abs(math.sin(best[4])) < _UNDECIDED and t < last else best

    nominal, joints = [0.0], [_start(arm, trajectory, solutions)]
    while nominal[-1] < last:
        t = min(nominal[-1] + step, last)
        guess = _extrapolated(nominal, joints, t)
        q = solve(t, guess)
        moved = math.inf if q is None else math.dist(q, joints[-1])
        # A step is good if it is short and where the last two led: then the branch is right.
        if q is None or moved > FINEST or math.dist(q, guess) > 0.1 * FINEST + 0.3 * moved:
            if step > _SHORTEST * last:
                step *= 0.5 if q is not None else 0.77
                continue
            raise InfeasibleMotion(
                f"{_gone(trajectory, t)} the path meets {_met(arm, joints[-1])} would have to jump."
            )
        nominal.append(t)
        joints.append(q)
        if watch is not None:
            watch(q)
        step = min(1.6 * step, last / _FEWEST) if moved < 0.4 * FINEST else step
    (nominal, joints), corners = with_reversals(nominal, joints, solve)
    for _ in range(_REFINEMENTS):
        made = AxisPath(joints, nominal, nominal, corners)
        loose = _loose(arm, trajectory, made)
        if not loose:
            break
        added = []
        for s in loose:
            # Halfway in time: what a loose spline says of it may lie beyond the next sample.
            t = float(np.interp(s, made.knots, made.way(made.knots)[:, 0]))
            added.append((t, solve(t, tuple(made.joints(np.array([s]))[0].tolist()))))
        rows = zip(nominal, joints, strict=True)
        both = sorted((*rows, *((t, q) for t, q in added if q is not None)), key=lambda row: row[0])
        nominal, joints = [t for t, _ in both], [q for _, q in both]
    return made


def _start(arm: Dimensions, trajectory: Trajectory, solutions: Inverse) -> Joints:
    """Return the joints at a path's beginning; at a singularity those with which it is left.

    There q1, or the difference of q4 and q6, is for whoever begins to choose, and one choice is
    that from which the joints go on without a jump.
    """
    start = trajectory.start
    if not _is_open(arm, start):
        return start
    begins = []
    for soon in (share * trajectory.duration for share in _LEAVING):
        for first in solutions(soon, start):
            second = min(solutions(2.0 * soon, first), key=lambda q: math.dist(q, first))
            guess = _extrapolated([2.0 * soon, soon], [second, first], 0.0)
            begin = _decided(arm, trajectory.pose(0.0), start, guess)
            if not _is_open(arm, first) and math.dist(begin, guess) < 0.1 * FINEST:
                begins.append(begin)
        if begins:
            break
    return min(begins, key=lambda q: math.dist(q, start), default=start)


def _is_open(arm: Dimensions, q: Joints) -> bool:
    """Return whether a singularity of shoulder or wrist leaves a joint open."""
    c, _ = wrist_in_plane(arm, q[1], q[2])
    return abs(math.sin(q[4])) < _UNDECIDED or (abs(c) < _UNDECIDED and arm.offset == 0.0)


def _decided(arm: Dimensions, pose: Pose, q: Joints, guess: Joints) -> Joints:
    """Return joints of a pose with what its singularity leaves open as it is guessed, rad."""
    c, _ = wrist_in_plane(arm, q[1], q[2])
    sign = 1 if math.sin(q[4]) >= 0.0 else -1
    q1 = guess[0] if abs(c) < _UNDECIDED and arm.offset == 0.0 else q[0]
    q = (q1, q[1], q[2], *wrist_joints(arm, pose, (q1, q[1], q[2]), sign, guess))
    if abs(math.sin(q[4])) < _UNDECIDED:
        turn = guess[3] - q[3] if math.cos(q[4]) > 0.0 else q[3] - guess[3]
        q = (*q[:3], guess[3], q[4], q[5] - turn)
    return nearest_turns(q, guess)


def _loose(arm: Dimensions, trajectory: Trajectory, path: AxisPath) -> list[float]:
    """Return the middles (rad) of those steps at which a joint path leaves the hand's path.

    A path may bend within less than a step, where its spline all but turns back.
    """
    middles = 0.5 * (path.knots[1:] + path.knots[:-1])
    found = []
    times = path.way(middles)[:, 0].tolist()
    for s, t, q in zip(middles.tolist(), times, path.joints(middles).tolist(), strict=True):
        wanted, made = trajectory.pose(t), forward(arm, tuple(q))
        turned = max(abs(e) for e in rotation_error(wanted.rotation, made.rotation))
        if math.dist(wanted.position, made.position) > _LOOSE or turned > _LOOSE_TURN:
            found.append(s)
    return found


def _met(arm: Dimensions, q: Joints) -> str:
    """Return in words at which singularity joints are, and which of them cannot go on."""
    c, s3, s5 = singularity_indices(arm, q)
    shares = [abs(its) / near for its, near in zip((c, s3, s5), NEAR, strict=True)]
    which = shares.index(min(shares))
    return (
        f"the shoulder's singularity (c = {c:.3g} m), which the joints do not pass smoothly: q1",
        f"the elbow's singularity (S3 = {s3:.3g}), beyond which it is not reached on this branch: "
        "q1 to q3",
        f"the wrist's singularity (S5 = {s5:.3g}), which the joints do not pass smoothly: "
        "q4 and q6",
    )[which]


def _farthest(trajectory: Trajectory, t: float, left: OutOfReach, reached: Inverse) -> str:
    """Return in words where a path, left at an instant, is farthest outside of the workspace."""
    most, at = left.beyond, t
    low, high, count = 0.0, trajectory.duration, _LOOKED_AT
    for _ in range(_CLOSER):
        for instant in np.linspace(low, high, count).tolist():
            try:
                reached(instant, trajectory.start)
            except OutOfReach as error:
                most, at = max((most, at), (error.beyond, instant))
        step = (high - low) / (count - 1)
        low, high = max(at - step, 0.0), min(at + step, trajectory.duration)
        count = _LOOKED_AT // 10
    told = f"It is farthest outside {_gone(trajectory, at)}, by {1e3 * most:.3g} mm."
    return f"{told}{_HELD}" if most < _SLIGHT and isinstance(trajectory, ThroughPlaces) else told


def _gone(trajectory: Trajectory, t: float) -> str:
    """Return in words how far along a path an instant is."""
    speed, unit = (trajectory.speed, "m") if trajectory.speed else (trajectory.turn_rate, "rad")
    gone = f"after {speed * t:.4f} {unit} of {speed * trajectory.duration:.4f} {unit}"
    return f"{gone}{where_on(trajectory, t)}"


def _extrapolated(nominal: list[float], joints: list[Joints], t: float) -> Joints:
    if len(joints) < 2:
        return joints[-1]
    share = (t - nominal[-1]) / (nominal[-1] - nominal[-2])
    q1, q2, q3, q4, q5, q6 = (
        b + share * (b - a) for a, b in zip(joints[-2], joints[-1], strict=True)
    )
    return q1, q2, q3, q4, q5, q6
