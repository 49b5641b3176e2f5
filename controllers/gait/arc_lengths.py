"""How long a phase is: of its path, and of the curve that its joints describe."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.gait.geometry import LegGeometry
from controllers.gait.phase_curve import PhaseCurve
from controllers.gait.phases import GaitPhase

Array = NDArray[np.float64]

_SAMPLES = 2000
"""Per phase, even; the joints' length then is good to 1e-9 rad."""


class Arcs(NamedTuple):
    """The lengths of a phase, cut into pieces.

    Parameters
    ----------
    path : ndarray
        Path parameter at the pieces' ends.
    path_pieces : ndarray
        Lengths along the path, m.
    joint_pieces : ndarray
        Lengths along the curve of all twelve joints, rad.
    joint_length : float
        Of the whole curve, extrapolated to infinitely many pieces, rad.
    steepest : float
        Greatest share that one joint has in the twelve joints' length.
    shares : ndarray
        The same of each piece.
    """

    path: Array
    path_pieces: Array
    joint_pieces: Array
    joint_length: float
    steepest: float
    shares: Array

    @property
    def path_length(self) -> float:
        """Of the whole path, m."""
        return float(np.sum(self.path_pieces))


def measure(geometry: LegGeometry, phase: GaitPhase) -> Arcs:
    """Measure a phase by the closed-form inverse.

    The pieces get shorter towards both ends as ``sin²``: where the path meets a straight knee,
    the knee goes with the square root of the distance that is left, which this makes regular.

    Raises
    ------
    InfeasibleMotion
        A leg does not reach some point of the path.
    """
    return _measure(geometry, phase._replace(duration=0.0))


@lru_cache(maxsize=256)
def _measure(geometry: LegGeometry, phase: GaitPhase) -> Arcs:
    curve = PhaseCurve(geometry, phase, 1.0)
    xi = np.sin(np.linspace(0.0, 0.5 * math.pi, _SAMPLES + 1)) ** 2
    joints = np.array([curve.joints_at(x) for x in xi.tolist()])
    steps = np.diff(joints, axis=0)
    fine = np.linalg.norm(steps, axis=1)
    coarse = np.linalg.norm(steps[::2] + steps[1::2], axis=1)
    # A chord is short by its length cubed: the classical extrapolation from twice the step.
    total = float(np.sum(fine) + (np.sum(fine) - np.sum(coarse)) / 3.0)
    moving = fine > 0.0
    shares = np.zeros(len(fine))
    shares[moving] = np.max(np.abs(steps[moving]), axis=1) / fine[moving]
    steepest = float(np.max(shares)) if moving.any() else 0.0
    middle = 0.5 * (xi[:-1] + xi[1:])
    speeds = [
        np.array([curve.speed(x) for x in points.tolist()]) for points in (xi[:-1], middle, xi[1:])
    ]
    pieces = np.diff(xi) * (speeds[0] + 4.0 * speeds[1] + speeds[2]) / 6.0
    scaled = fine * (total / float(np.sum(fine))) if moving.any() else fine
    return Arcs(xi, pieces, scaled, total, steepest, shares)
