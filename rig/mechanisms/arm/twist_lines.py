"""How far a hand gets off the lines and screws that constant twists are."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of, forward
from controllers.arm.online.commands import ArmTwists, twist_at
from controllers.arm.plan import ArmPlan

Array = NDArray[np.float64]

_SLOWEST = 1e-9
"""m/s or rad/s: what is slower has no line that the hand could be held against."""
_TAKEN_UP = 0.5
"""From so long after a twist has changed on the hand is held against it, s."""
_ROUNDS = 3
"""Newton's, for the nearest place of a screw."""
_NO_TURN = 1e-8
"""rad: by so little a screw is a line."""


def off_direction(plan: ArmPlan, geometry: ArmGeometry, asked: ArmTwists) -> tuple[float, float]:
    """Return how far the hand gets off what the twists are (m), and the tool (rad).

    In the base's axes a twist is a line with a turn beside it, in the tool's a screw. It begins
    where the hand is `_TAKEN_UP` after the twist has changed, and ends with it. The tool is held
    against the turn that belongs to how far the hand, or without a velocity the tool itself, has
    gone.
    """
    arm = dimensions_of(geometry)
    own = _own_axes(plan, asked)
    same = np.all(np.diff(own, axis=0) == 0.0, axis=1)
    starts = [0, *(np.flatnonzero(~same) + 1).tolist(), len(plan.t)]
    wait = math.ceil(_TAKEN_UP / plan.period)
    away = turned = 0.0
    for begin, end in pairwise(starts):
        twist = np.where(np.abs(own[begin]) < _SLOWEST, 0.0, own[begin])
        first = begin + wait
        if first + 1 >= end or not twist.any():
            continue
        gone = plan.hand[first:end] - plan.hand[first]
        rotations = np.array([forward(arm, tuple(q)).rotation for q in plan.positions[first:end]])
        v, w = twist[:3], twist[3:]
        if asked.frame == "tool":
            gone, turns = gone @ rotations[0], rotations[0].T @ rotations
            progress = _along_screw(gone, turns, v, w)
            gone = gone - _screw(progress, v, w)
        else:
            turns = rotations @ rotations[0].T
            progress = gone @ v / (v @ v) if v.any() else _by_turning(turns, w)
            gone = gone - np.outer(progress, v)
        away = max(away, float(np.linalg.norm(gone, axis=1).max()))
        turned = max(turned, _beside(turns, progress, w))
    return away, turned


def _own_axes(plan: ArmPlan, asked: ArmTwists) -> Array:
    """Return what is asked for in each cycle in the axes in which it is given, shape (n, 6)."""
    rows = asked.known()
    if asked.frame == "base" or rows is None:
        return plan.command
    return np.array([twist_at(rows, t) for t in plan.t.tolist()])


def _screw(progress: Array, v: Array, w: Array) -> Array:
    """Return where a twist of a body leads that it is done for so long (s), m, shape (n, 3)."""
    rate = float(np.linalg.norm(w))
    angle = rate * progress
    whole = np.outer(progress, v)
    if np.abs(angle).max(initial=0.0) < _NO_TURN:
        return whole
    across, back = np.cross(w, v) / rate**2, np.cross(w, np.cross(w, v)) / rate**3
    half = 2.0 * np.sin(0.5 * angle) ** 2  # 1 - cos, without losing the digits of a small turn
    return np.asarray(whole + np.outer(half, across) + np.outer(angle - np.sin(angle), back))


def _along_screw(gone: Array, turns: Array, v: Array, w: Array) -> Array:
    """Return for how long the twist of a body would have had to be done, s, shape (n,)."""
    if not v.any():
        return _by_turning(turns, w)
    steps = np.diff(gone, axis=0)
    ahead = turns[:-1] @ v
    progress = np.concatenate(([0.0], np.cumsum(np.sum(steps * ahead, axis=1) / (v @ v))))
    for _ in range(_ROUNDS):
        beside = gone - _screw(progress, v, w)
        progress = progress + np.sum(beside * (_turned(progress, w) @ v), axis=1) / (v @ v)
    return np.asarray(progress, dtype=np.float64)


def _turned(progress: Array, w: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(np.outer(progress, w)).as_matrix())


def _by_turning(turns: Array, w: Array) -> Array:
    """Return for how long a turn would have had to be done, s, shape (n,)."""
    from scipy.spatial.transform import Rotation

    steps = Rotation.from_matrix(turns[1:] @ np.transpose(turns[:-1], (0, 2, 1))).as_rotvec()
    return np.concatenate(([0.0], np.cumsum(steps @ w / (w @ w))))


def _beside(turns: Array, progress: Array, w: Array) -> float:
    """Return the greatest angle of the tool from where the progress has it, rad."""
    from scipy.spatial.transform import Rotation

    wanted = Rotation.from_rotvec(np.outer(progress, w))
    return float((Rotation.from_matrix(turns) * wanted.inv()).magnitude().max())
