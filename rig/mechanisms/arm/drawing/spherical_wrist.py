"""From six axes to the dimensions of the arm that the laws move, or the reason why it is none.

Covered is what has a closed inverse of the laws' kind: q2 and q3 parallel, q1 at right angles to
them, and a wrist whose axes meet in a point, at right angles each to the next, its first at right
angles to q3. All lengths are free: shoulder and elbow may be offset.
"""

import math
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from rig.mechanisms.arm.drawing.chain import (
    Array,
    Chain,
    DrawingError,
    DrawnJoint,
    gap,
    meeting_point,
    turn_about,
)

_ANGLE = 1e-4
"""rad: a description with angles of four digits is off by so much."""
_LENGTH = 2e-5
"""m."""
_NO_LENGTH = 1e-9
"""m, below which a length is rounding."""

Six = tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Drawing:
    """An arm in the laws' own terms.

    Parameters
    ----------
    lengths : dict
        Of `ArmGeometry`, m: a1, a2, a3, d6, base_height, elbow_offset, shoulder_offset.
    signs, zeros : tuple of float
        The laws' joint is ``sign * drawn joint + zero`` (rad).
    base_position, base_rotation : ndarray
        Of the laws' base in the drawing's: m, and drawing from laws.
    tip_rotation : ndarray, shape (3, 3)
        The laws' tool from the drawing's tip.
    """

    lengths: dict[str, float]
    signs: Six
    zeros: Six
    base_position: Array
    base_rotation: Array
    tip_rotation: Array

    @property
    def geometry(self) -> ArmGeometry:
        """The arm with these lengths, and the usual ranges and limits."""
        its = self.lengths
        return ArmGeometry(
            a1=its["a1"],
            a2=its["a2"],
            a3=its["a3"],
            d6=its["d6"],
            base_height=its["base_height"],
            elbow_offset=its["elbow_offset"],
            shoulder_offset=its["shoulder_offset"],
        )

    def joints_of(self, drawn: Array) -> Six:
        """Return the laws' joints for the drawing's, rad."""
        q1, q2, q3, q4, q5, q6 = (np.array(self.signs) * drawn + np.array(self.zeros)).tolist()
        return q1, q2, q3, q4, q5, q6


def recognise(chain: Chain) -> Drawing:
    """Return the dimensions of an arm.

    Raises
    ------
    DrawingError
        It has no closed inverse here: which axes are not as they should be, and by how much.
    """
    _check_axes(chain)
    plane = _plane_of(chain)
    lengths, (q1, q2, q3), forearm = _position_part(chain, plane)
    fore_x = np.cross((0.0, 1.0, 0.0), forearm)
    bend = plane.across.T @ chain.joints[4].axis
    if bend[1] < -_ANGLE or (abs(bend[1]) <= _ANGLE and bend @ fore_x > 0.0):
        bend = -bend
    tool, lengths["d6"] = _tool_of(chain, plane)
    q4 = math.atan2(-float(bend @ fore_x), float(bend[1]))
    q5 = math.atan2(float(tool @ np.cross(bend, forearm)), float(tool @ forearm))
    # What is x of the tool at q6 = 0 lies in the plane of q4 and q5.
    tool_x = np.cross(bend, tool)
    tip_axes = plane.across.T @ chain.tip_rotation
    level = tip_axes[:, int(np.argmin(np.abs(tool @ tip_axes).round(6)))]  # x if it is level
    q6 = math.atan2(float(level @ bend), float(level @ tool_x))
    side, across = plane.across[:, 1], plane.across
    axes = (plane.up, side, side, across @ forearm, across @ bend, across @ tool)
    signs = [
        1.0 if joint.axis @ axis > 0.0 else -1.0
        for joint, axis in zip(chain.joints, axes, strict=True)
    ]
    zeros = [
        _centred(joint, sign, zero)
        for joint, sign, zero in zip(chain.joints, signs, (q1, q2, q3, q4, q5, q6), strict=True)
    ]
    turned = turn_about(tool, q6) @ np.column_stack((tool_x, bend, tool))
    return Drawing(
        {name: 0.0 if abs(value) < _NO_LENGTH else value for name, value in lengths.items()},
        _six(signs),
        _six(zeros),
        plane.base,
        plane.rotation,
        turned.T @ tip_axes,
    )


class _Plane(NamedTuple):
    """The arm's plane at zero: base and wrist centre, and its axes ahead, aside and up."""

    base: Array
    rotation: Array
    up: Array
    wrist: Array
    across: Array


def _plane_of(chain: Chain) -> _Plane:
    """Return the arm's plane; of the two directions of q2 the one with which it reaches ahead."""
    first, second = chain.joints[:2]
    up = first.axis if first.axis[2] > -_ANGLE else -first.axis
    base = first.point - (first.point @ first.axis) * first.axis
    wrist = meeting_point(chain.joints[3:])
    side = second.axis
    ahead = np.cross(side, up)
    a1 = float(ahead @ (second.point - base))
    if a1 < -_NO_LENGTH or (abs(a1) <= _NO_LENGTH and ahead @ (wrist - base) < -_NO_LENGTH):
        side, ahead = -side, -ahead
    return _Plane(base, _upright(up), up, wrist, np.column_stack((ahead, side, up)))


def _position_part(
    chain: Chain, plane: _Plane
) -> tuple[dict[str, float], tuple[float, float, float], Array]:
    """Return the lengths up to the wrist, q1 to q3 at zero, and the forearm in the plane's axes."""
    points = (chain.joints[1].point, chain.joints[2].point, plane.wrist)
    shoulder, elbow, centre = (plane.across.T @ (point - plane.base) for point in points)
    lean = math.atan2(elbow[0] - shoulder[0], elbow[2] - shoulder[2])
    forearm = plane.across.T @ chain.joints[3].axis
    if forearm @ (centre - elbow) < 0.0:
        forearm = -forearm
    lengths = {
        "a1": float(shoulder[0]),
        "a2": math.hypot(elbow[0] - shoulder[0], elbow[2] - shoulder[2]),
        "a3": float(forearm @ (centre - elbow)),
        "d6": 0.0,
        "base_height": float(shoulder[2]),
        "elbow_offset": float(np.cross((0.0, 1.0, 0.0), forearm) @ (centre - elbow)),
        "shoulder_offset": float(centre[1]),
    }
    for words, name in (("q2 to q3", "a2"), ("q3 to the wrist along q4", "a3")):
        if lengths[name] < _LENGTH:
            raise DrawingError(
                f"{chain.source}: from {words} it is {1e3 * lengths[name]:.3g} mm; the laws need a "
                f"length"
            )
    out = plane.rotation.T @ plane.across[:, 0]
    turned = math.atan2(out[1], out[0])
    return lengths, (turned, lean, math.atan2(forearm[0], forearm[2]) - lean), forearm


def _tool_of(chain: Chain, plane: _Plane) -> tuple[Array, float]:
    """Return the tool's axis in the plane's axes, and how far the tool point is along it, m."""
    tool = plane.across.T @ chain.joints[5].axis
    tip = plane.across.T @ (chain.tip_position - plane.wrist)
    along = float(tool @ tip)
    ahead = float(tool @ plane.across.T @ chain.tip_rotation[:, 2])
    if along < -_NO_LENGTH or (abs(along) <= _NO_LENGTH and ahead < 0.0):
        tool, along = -tool, -along
    off = float(np.linalg.norm(tip - along * tool))
    if off > _LENGTH:
        raise DrawingError(
            f"{chain.source}: {chain.tip} is {1e3 * off:.4g} mm beside the axis of "
            f"{chain.joints[5].name}; the laws move a point on it: name a link there with --tip"
        )
    return tool, along


def _check_axes(chain: Chain) -> None:
    """Raise if axes are not as the laws need them, with every reason."""
    joints = chain.joints
    wrong = []
    for one, other in ((0, 1), (2, 3), (3, 4), (4, 5)):
        angle = _between(joints[one].axis, joints[other].axis)
        if abs(angle - 0.5 * math.pi) > _ANGLE:
            wrong.append(f"{_named(joints, one, other)} are {_degrees(angle)} apart instead of 90")
    lean = _between(joints[1].axis, joints[2].axis)
    if lean > _ANGLE:
        wrong.append(f"{_named(joints, 1, 2)} are {_degrees(lean)} from parallel")
    far = {pair: gap(joints[pair[0]], joints[pair[1]]) for pair in combinations((3, 4, 5), 2)}
    for pair, apart in far.items():
        if apart > _LENGTH:
            wrong.append(
                f"{_named(joints, *pair)} pass {1e3 * apart:.4g} mm apart instead of meeting"
            )
    if not wrong:
        centre = meeting_point(joints[3:])
        off = max(
            float(np.linalg.norm(np.cross(joint.axis, centre - joint.point)))
            for joint in joints[3:]
        )
        if off > _LENGTH:
            wrong.append(f"the wrist's axes meet in no one point but {1e3 * off:.4g} mm from one")
    if wrong:
        raise DrawingError(
            f"{chain.source}: no closed inverse is known here, because the axes of "
            f"{'; of '.join(wrong)}"
        )


def _named(joints: tuple[DrawnJoint, ...], one: int, other: int) -> str:
    return f"{joints[one].name} and {joints[other].name} ({AXIS_NAMES[one]}, {AXIS_NAMES[other]})"


def _between(one: Array, other: Array) -> float:
    """Return the acute angle between two directions, rad."""
    return math.atan2(float(np.linalg.norm(np.cross(one, other))), abs(float(one @ other)))


def _degrees(angle: float) -> str:
    return f"{round(math.degrees(angle), 6):.4g} degrees"


def _upright(up: Array) -> Array:
    """Return the shortest rotation that brings z to a direction not far below the horizon."""
    x, y, z = up
    share = 1.0 / (1.0 + z)
    return np.array(
        (
            (1.0 - share * x * x, -share * x * y, x),
            (-share * x * y, 1.0 - share * y * y, y),
            (-x, -y, z),
        )
    )


def _centred(joint: DrawnJoint, sign: float, zero: float) -> float:
    """Return the zero with whole turns added so that the joint's range is about 0."""
    middle = zero
    if math.isfinite(joint.lower) and math.isfinite(joint.upper):
        middle += sign * 0.5 * (joint.lower + joint.upper)
    return zero - 2.0 * math.pi * round(middle / (2.0 * math.pi))


def _six(values: list[float]) -> Six:
    q1, q2, q3, q4, q5, q6 = values
    return q1, q2, q3, q4, q5, q6
