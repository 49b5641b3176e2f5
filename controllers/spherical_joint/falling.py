"""The pull of the tensions on a ring that is off the pose that they hold.

Round a ball a wire's lever grows on the side that the ring tilts to: tensions that balance in one
pose pull the ring on wherever it gets off it. Control has to be quicker than it falls.
"""

import math
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.poses import Vector, axis_from_tilt, natural_rotation
from controllers.spherical_joint.taut import pair_forces
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.wires import InverseKinematics

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Number = TypeVar("Number", float, "NDArray[np.float64]")

_TILT = 1e-3
"""Of the pose that upright is compared with, rad."""
_PAIRS = (0, 2), (3, 1)
"""Agonist and antagonist of each pair, as `pair_forces` has them."""
_REST: Vector = (0.0, 0.0, 0.0)


def falling_stiffness(geometry: SphericalJointGeometry, tension: float) -> float:
    """Return the force with which a pair is pulled back over how far it is off upright, N/m.

    Parameters
    ----------
    geometry : SphericalJointGeometry
        Dimensions, of exact wires.
    tension : float
        Of each wire, N.

    Returns
    -------
    float
        Of the pair that is pulled on most; negative where it is, as it is round any ball.
    """
    found = math.inf
    for pair, (agonist, _) in enumerate(_PAIRS):
        offs, forces = _pull_at(geometry, _TILT, geometry.anchor_angles[agonist])
        found = min(found, -tension * forces[pair] / offs[pair])
    return found


class Falling(NamedTuple):
    """The pull of even tensions on a ring that leans far, to the third power of how far.

    Parameters
    ----------
    stiffness : float
        Force on a pair over how far it is off upright and over the tension of a wire, 1/m.
    own, beside : float
        By which share that grows with the square of how far the pair itself is off, and the other
        one, 1/m².
    """

    stiffness: float
    own: float
    beside: float

    def pull(self, off: Number, beside: Number) -> Number:
        """Return the force on a pair over the tension.

        Parameters
        ----------
        off, beside : float or ndarray
            How far the pair is off upright, and the other one, m.
        """
        grows = 1.0 + self.own * off * off + self.beside * beside * beside
        return self.stiffness * off * grows


def falling_pull(geometry: SphericalJointGeometry, tilt: float) -> Falling:
    """Return how a ring falls up to about a tilt, rad.

    Exact upright, at that tilt towards a wire and midway between two.
    """
    stiffness = -falling_stiffness(geometry, 1.0)
    first, second = geometry.anchor_angles[:2]
    offs, forces = _pull_at(geometry, tilt, first)
    own = (forces[0] / (stiffness * offs[0]) - 1.0) / offs[0] ** 2
    offs, forces = _pull_at(geometry, tilt, 0.5 * (first + second))
    grows = forces[0] / (stiffness * offs[0]) - 1.0
    return Falling(stiffness, own, (grows - own * offs[0] ** 2) / offs[1] ** 2)


def _pull_at(
    geometry: SphericalJointGeometry, tilt: float, azimuth: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return how far each pair is off upright (m) in a pose, and how 1 N in each wire pulls it."""
    axis = axis_from_tilt(tilt, azimuth)
    rods, _, _ = InverseKinematics(geometry).motion(axis, _REST, _REST)
    _, first, second = TensionDistribution(geometry).at(natural_rotation(axis))
    offs = [0.5 * (rods[agonist] - rods[antagonist]) for agonist, antagonist in _PAIRS]
    return (offs[0], offs[1]), pair_forces(first, second, (1.0,) * 4)
