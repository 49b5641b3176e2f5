"""Rotations and poses of the simulated side, computed another way than the detector does."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class MarkerPose(NamedTuple):
    """The pose of a marker.

    Attributes
    ----------
    position : sequence of float, length 3
        Its centre in the joint's base frame, m.
    rotation : sequence of sequence of float, shape (3, 3)
        Its axes as columns, in the base frame; z is its normal.
    """

    position: Sequence[float]
    rotation: Sequence[Sequence[float]]


def rotation_matrix(vector: Sequence[float]) -> Floats:
    """Return the rotation matrix of a rotation vector (rad), by its exponential series."""
    x, y, z = vector
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # Scaling and squaring: the series of a small rotation needs few terms.
    small = skew / 256.0
    term = turn = np.eye(3)
    for k in range(1, 9):
        term = term @ small / k
        turn = turn + term
    for _ in range(8):
        turn = turn @ turn
    return turn


def twist_of(rotation: Sequence[Sequence[float]]) -> float:
    """Return the twist of a rotation about its own z axis, rad, by its quaternion's w and z."""
    trace = rotation[0][0] + rotation[1][1] + rotation[2][2]
    twist = 2.0 * math.atan2(rotation[1][0] - rotation[0][1], 1.0 + trace)
    return math.remainder(twist, math.tau)
