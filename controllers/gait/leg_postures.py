"""Where knees, ankles and soles are at many instants at once; for plans, figures and measures."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.gait.geometry import LegGeometry

Array = NDArray[np.float64]


class LegPosture(NamedTuple):
    """One leg under an upright waist at n instants, seen from the waist.

    Parameters
    ----------
    hip, knee, ankle, sole : ndarray, shape (n, 3)
        Positions, m; the sole's is the point under the ankle.
    thigh, shank : ndarray, shape (n, 3)
        Unit vectors down these links.
    foot : ndarray, shape (n, 3, 3)
        Rotation waist from foot.
    """

    hip: Array
    knee: Array
    ankle: Array
    sole: Array
    thigh: Array
    shank: Array
    foot: Array


def leg_posture(geometry: LegGeometry, leg: int, q: Array) -> LegPosture:
    """Return where the parts of a leg are.

    Parameters
    ----------
    geometry : LegGeometry
        Lengths.
    leg : int
        0 right, 1 left.
    q : ndarray, shape (n, 12)
        Joint angles of both legs, rad.
    """
    yaw, roll, pitch, knee, ankle_pitch, ankle_roll = q[:, 6 * leg : 6 * leg + 6].T
    turned = _rotation(yaw, 0, 1) @ _rotation(roll, 1, 2)
    thigh = -(turned @ _rotation(pitch, 2, 0))[..., 2]
    shank = -(turned @ _rotation(pitch + knee, 2, 0))[..., 2]
    foot = turned @ _rotation(pitch + knee + ankle_pitch, 2, 0) @ _rotation(ankle_roll, 1, 2)
    hip = np.broadcast_to(np.array((0.0, geometry.side(leg), 0.0)), thigh.shape)
    knee_at = hip + geometry.thigh * thigh
    ankle_at = knee_at + geometry.shank * shank
    sole_at = ankle_at - geometry.ankle_height * foot[..., 2]
    return LegPosture(hip, knee_at, ankle_at, sole_at, thigh, shank, foot)


def rotations(attitudes: Array) -> Array:
    """Return the rotations ground from sole, shape (n, 3, 3).

    Parameters
    ----------
    attitudes : ndarray, shape (n, 3)
        Roll, pitch and yaw, rad.
    """
    roll, pitch, yaw = attitudes.T
    turned: Array = _rotation(yaw, 0, 1) @ _rotation(pitch, 2, 0) @ _rotation(roll, 1, 2)
    return turned


def waist_from_foot(posture: LegPosture, attitudes: Array) -> Array:
    """Return the waist's position from the sole in the ground's frame, shape (n, 3), m.

    Parameters
    ----------
    posture : LegPosture
        The leg seen from the waist.
    attitudes : ndarray, shape (n, 3)
        Roll, pitch and yaw of its sole on the ground, rad.
    """
    seen: Array = -np.einsum("nji,nj->ni", posture.foot, posture.sole)
    return np.asarray(np.einsum("nij,nj->ni", rotations(attitudes), seen), dtype=np.float64)


def mismatch(geometry: LegGeometry, q: Array, feet: Array, attitudes: Array) -> Array:
    """Return by how much the two feet disagree on where the waist is, m.

    Parameters
    ----------
    geometry : LegGeometry
        Lengths.
    q : ndarray, shape (n, 12)
        Joint angles, rad.
    feet : ndarray, shape (n, 2, 3)
        Where right and left sole are, m.
    attitudes : ndarray, shape (n, 2, 3)
        How they lie: roll, pitch and yaw, rad.
    """
    right, left = (
        feet[:, leg] + waist_from_foot(leg_posture(geometry, leg, q), attitudes[:, leg])
        for leg in (0, 1)
    )
    apart: Array = np.linalg.norm(right - left, axis=1)
    return apart


def quantised(q: Array, resolution: float) -> Array:
    """Return joint angles as a servo with this resolution (rad) takes them."""
    rounded: Array = np.round(q / resolution) * resolution
    return rounded


def _rotation(angle: Array, first: int, second: int) -> Array:
    matrix = np.zeros((len(angle), 3, 3))
    matrix[:, range(3), range(3)] = 1.0
    matrix[:, first, first] = matrix[:, second, second] = np.cos(angle)
    matrix[:, first, second] = -np.sin(angle)
    matrix[:, second, first] = np.sin(angle)
    return matrix
