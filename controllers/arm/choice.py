"""On which branch and how many turns away a path is begun, if not as near as it was asked for."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

from controllers.arm.geometry import AXIS_NAMES
from controllers.arm.inverse import BRANCHES, Branch, branch_of, reachable
from controllers.arm.kinematics import Dimensions
from controllers.arm.plan import ArmPlan, OutOfRange
from controllers.arm.pose_path import PosePath
from controllers.arm.types import Joints
from controllers.motion import InfeasibleMotion

_SIDES = (("reaching ahead", "reaching back"), ("elbow +", "elbow -"), ("wrist +", "wrist -"))


def begun_elsewhere(
    arm: Dimensions, path: PosePath, refused: OutOfRange, planned: Callable[[PosePath], ArmPlan]
) -> ArmPlan:
    """Return the plan of a path that begins where all joints keep their ranges.

    First whole turns away, then on the arm's other branches, the nearest first.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    path : PosePath
        Of which a joint leaves its range.
    refused : OutOfRange
        How it does.
    planned : function
        From a path to its plan.

    Raises
    ------
    OutOfRange
        There is no such beginning.
    """
    why = f"from the nearest beginning (near, begin), {str(refused).rstrip('.')}"
    if refused.turns is not None:
        made = planned(path.turned(refused.turns))
        return _noted(made, f"{_turned(refused.turns)}: {why}")
    tried = 0
    for begin in _beginnings(arm, path):
        other = replace(path, begin=begin)
        tried += 1
        try:
            made = planned(other)
        except OutOfRange as error:
            if error.turns is None:
                continue
            made = planned(other.turned(error.turns))
        except InfeasibleMotion:
            continue
        return _noted(made, f"on the branch {branch_words(branch_of(arm, begin))}: {why}")
    raise OutOfRange(f"{refused} None of {tried} other branches keeps all ranges.", None)


def branch_words(branch: Branch) -> str:
    """Return a branch in words."""
    return ", ".join(names[sign < 0] for names, sign in zip(_SIDES, branch, strict=True))


def _noted(plan: ArmPlan, note: str) -> ArmPlan:
    return replace(plan, notes=(*plan.notes, note))


def _turned(turns: Joints) -> str:
    told = [
        f"{name} by {round(turn / math.tau):+d}"
        for name, turn in zip(AXIS_NAMES, turns, strict=True)
        if turn
    ]
    return f"whole turns away, {' and '.join(told)}"


def _beginnings(arm: Dimensions, path: PosePath) -> Iterator[Joints]:
    """Yield the joints of the other branches at a path's beginning, the nearest to `near` first."""
    trajectory = path.trajectory(arm)
    taken = trajectory.start
    found = reachable(arm, trajectory.pose(0.0), BRANCHES, path.near)
    for q in sorted(found, key=lambda q: math.dist(q, path.near)):
        if math.dist(q, taken) > 1e-6:
            yield q
