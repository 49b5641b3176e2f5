"""The joints for a pose, in closed form, on all branches."""

import math
from collections.abc import Iterable
from itertools import product
from typing import NamedTuple

from controllers.arm.kinematics import Dimensions
from controllers.arm.types import Joints, Pose, Vector

_TURN = 2.0 * math.pi
_ROUNDING = 1e-8
"""m: a wrist centre that is no farther beyond its reach is at the boundary."""


class Branch(NamedTuple):
    """One of the eight solutions: the signs of c (shoulder), of S3 (elbow) and of S5 (wrist)."""

    shoulder: int
    elbow: int
    wrist: int


BRANCHES = tuple(Branch(*signs) for signs in product((1, -1), repeat=3))


class OutOfReach(ValueError):
    """No joints lead to the pose.

    Attributes
    ----------
    beyond : float
        How far the wrist centre is outside, m.
    """

    def __init__(self, message: str, beyond: float) -> None:
        super().__init__(message)
        self.beyond = beyond


def wrist_of_pose(arm: Dimensions, pose: Pose) -> Vector:
    """Return the wrist centre of a pose, m; Miyata et al., eq. (1) in position."""
    (x, y, z), rotation = pose
    return (
        x - arm.d6 * rotation[0][2],
        y - arm.d6 * rotation[1][2],
        z - arm.d6 * rotation[2][2],
    )


def branch_of(arm: Dimensions, q: Joints) -> Branch:
    """Return the branch that the joints are on; +1 at a singularity."""
    q23 = q[1] + q[2] + arm.elbow_angle
    c = arm.a2 * math.sin(q[1]) + arm.a3 * math.sin(q23) + arm.a1
    return Branch(
        1 if c >= 0.0 else -1,
        1 if math.sin(q[2] + arm.elbow_angle) >= 0.0 else -1,
        1 if math.sin(q[4]) >= 0.0 else -1,
    )


def inverse(arm: Dimensions, pose: Pose, branch: Branch, near: Joints | None = None) -> Joints:
    """Return the joints (rad) of one branch.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    pose : Pose
        Of the tool.
    branch : Branch
        Which solution.
    near : tuple of float, optional
        Whole turns are added so that each joint is the nearest to these, and what a singularity
        leaves open (q1 on the axis, q4 with the tool along the forearm) is taken from them.

    Raises
    ------
    OutOfReach
        The wrist centre is beyond the arm's reach, or within its inner boundary or its void.

    Notes
    -----
    The elbow comes from half its angle, whose tangent is the quotient of two well conditioned
    roots, so that neither the stretched nor the folded arm loses digits, with ``a2 = a3`` or not.
    """
    x, y, z = wrist_of_pose(arm, pose)
    z -= arm.height
    beyond = x * x + y * y - arm.offset * arm.offset
    if beyond < 0.0:
        raise OutOfReach(
            f"the wrist centre is {math.hypot(x, y):.6g} m from the axis of q1, within the "
            f"shoulder's offset of {abs(arm.offset):g} m",
            abs(arm.offset) - math.hypot(x, y),
        )
    c = branch.shoulder * math.sqrt(beyond)
    if beyond == 0.0 and arm.offset == 0.0:
        q1 = near[0] if near is not None else 0.0
    else:
        q1 = math.atan2(y, x) - math.atan2(arm.offset, c)
    ahead = c - arm.a1
    r = math.hypot(ahead, z)
    outer = (arm.a2 + arm.a3 - r) * (arm.a2 + arm.a3 + r)
    inner = (r - arm.a2 + arm.a3) * (r + arm.a2 - arm.a3)
    least = -_ROUNDING * (arm.a2 + arm.a3 + r)
    if outer < least or inner < least:
        raise OutOfReach(
            f"the wrist centre is {r:.9g} m from the shoulder; the arm reaches from "
            f"{abs(arm.a2 - arm.a3):.9g} m to {arm.a2 + arm.a3:.9g} m",
            max(r - arm.a2 - arm.a3, abs(arm.a2 - arm.a3) - r),
        )
    outer, inner = max(outer, 0.0), max(inner, 0.0)
    elbow = branch.elbow * 2.0 * math.atan2(math.sqrt(outer), math.sqrt(inner))
    q2 = math.atan2(ahead, z) - lean_of(arm, elbow)
    q3 = elbow - arm.elbow_angle
    position = (q1, q2, q3)
    q = (*position, *wrist_joints(arm, pose, position, branch.wrist, near))
    return q if near is None else nearest_turns(q, near)


def lean_of(arm: Dimensions, elbow: float) -> float:
    """Return the angle from the upper arm to the wrist centre with a bent elbow, both rad."""
    if arm.a2 == arm.a3:
        return 0.5 * elbow
    return math.atan2(arm.a3 * math.sin(elbow), arm.a2 + arm.a3 * math.cos(elbow))


def reachable(
    arm: Dimensions, pose: Pose, branches: Iterable[Branch], near: Joints
) -> list[Joints]:
    """Return the joints (rad) of those branches on which a pose is reached.

    With `a1` an arm that leans back reaches less far than one that leans ahead.

    Raises
    ------
    OutOfReach
        It is reached on none; of all refusals that of the branch that is nearest to it.
    """
    found: list[Joints] = []
    refused: OutOfReach | None = None
    for branch in branches:
        try:
            found.append(inverse(arm, pose, branch, near))
        except OutOfReach as error:
            refused = error if refused is None or error.beyond < refused.beyond else refused
    if refused is not None and not found:
        raise refused
    return found


def wrist_joints(
    arm: Dimensions,
    pose: Pose,
    position: tuple[float, float, float],
    sign: int,
    near: Joints | None = None,
) -> Vector:
    """Return q4, q5, q6 (rad) for a pose whose q1, q2, q3 are known; `sign` is that of S5."""
    q1, q2, q3 = position
    c1, s1, c23, s23 = math.cos(q1), math.sin(q1), math.cos(q2 + q3), math.sin(q2 + q3)
    r0, r1, r2 = pose.rotation
    # Rows of R_36 = (Rz(q1) Ry(q2 + q3))^T R: its last column is the tool in the forearm's axes.
    x, y, z = (
        tuple(a * r0[j] + b * r1[j] + c * r2[j] for j in range(3))
        for a, b, c in ((c23 * c1, c23 * s1, -s23), (-s1, c1, 0.0), (s23 * c1, s23 * s1, c23))
    )
    lean = math.hypot(x[2], y[2])
    q5 = math.atan2(sign * lean, z[2])
    if lean < 1e-14:
        q4 = near[3] if near is not None else 0.0
        about = math.atan2(y[0], y[1])  # q4 + q6, or q6 - q4 with the tool folded back
        return q4, q5, about - q4 if z[2] > 0.0 else about + q4
    side = arm.wrist_sign * sign
    q4 = math.atan2(side * y[2], side * x[2])
    q6 = math.atan2(side * z[1], -side * z[0])
    return q4, q5, q6


def nearest_turns(q: Joints, near: Joints) -> Joints:
    """Return the joints with whole turns added so that each is the nearest to `near`."""
    q1, q2, q3, q4, q5, q6 = (
        a - _TURN * round((a - b) / _TURN) for a, b in zip(q, near, strict=True)
    )
    return q1, q2, q3, q4, q5, q6
