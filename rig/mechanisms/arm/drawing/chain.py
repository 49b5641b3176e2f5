"""Six axes in space: what any description of an arm comes to at its own zero."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rig.hal import ConfigurationError

Array = NDArray[np.float64]


class DrawingError(ConfigurationError):
    """A description is none of an arm that the laws cover, or cannot be read."""


class DrawnJoint(NamedTuple):
    """A joint, all others at zero.

    Parameters
    ----------
    name : str
        As the description has it.
    point : ndarray, shape (3,)
        On the axis, base axes, m.
    axis : ndarray, shape (3,)
        Unit vector about which it turns, base axes.
    lower, upper : float
        Its range, rad; infinite if nothing is said.
    speed, effort : float, optional
        Greatest speed, rad/s, and torque, N m.
    is_ranged : bool
        Whether that range is the description's: of any other nothing is known.
    """

    name: str
    point: Array
    axis: Array
    lower: float = -math.inf
    upper: float = math.inf
    speed: float | None = None
    effort: float | None = None
    is_ranged: bool = True


@dataclass(frozen=True, slots=True)
class Chain:
    """An arm as drawn.

    Parameters
    ----------
    source : str
        The description, in words.
    joints : tuple of DrawnJoint
        Six, from the base outwards.
    base, tip : str
        What base and tip are called.
    tip_position : ndarray, shape (3,)
        At zero, base axes, m.
    tip_rotation : ndarray, shape (3, 3)
        At zero, base from tip.
    """

    source: str
    joints: tuple[DrawnJoint, ...]
    base: str
    tip: str
    tip_position: Array
    tip_rotation: Array

    def tip_at(self, angles: Sequence[float]) -> tuple[Array, Array]:
        """Return position (m) and rotation of the tip for joint angles (rad): one turn each."""
        position, rotation = self.tip_position, self.tip_rotation
        for joint, angle in zip(reversed(self.joints), reversed(angles), strict=True):
            turn = turn_about(joint.axis, angle)
            position = joint.point + turn @ (position - joint.point)
            rotation = turn @ rotation
        return position, rotation


def turn_about(axis: Array, angle: float) -> Array:
    """Return a rotation about a unit vector by an angle (rad), after Rodrigues."""
    x, y, z = axis
    cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    turn: Array = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return turn


def gap(one: DrawnJoint, other: DrawnJoint) -> float:
    """Return the least distance of two axes, m."""
    normal = np.cross(one.axis, other.axis)
    away = other.point - one.point
    size = float(np.linalg.norm(normal))
    if size < 1e-9:
        return float(np.linalg.norm(np.cross(one.axis, away)))
    return abs(float(away @ normal)) / size


def meeting_point(joints: Sequence[DrawnJoint]) -> Array:
    """Return the point whose distances from axes have the least sum of squares, m."""
    across = [np.eye(3) - np.outer(joint.axis, joint.axis) for joint in joints]
    right = np.sum(
        [matrix @ joint.point for matrix, joint in zip(across, joints, strict=True)], axis=0
    )
    return np.asarray(np.linalg.solve(np.sum(across, axis=0), right))
