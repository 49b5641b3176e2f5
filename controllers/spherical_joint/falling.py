"""The pull of the tensions on a ring that is off the pose that they hold.

Round a ball a wire's lever grows on the side that the ring tilts to: tensions that balance in one
pose pull the ring on wherever it gets off it. Control has to be quicker than it falls.
"""

import math

from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.poses import Vector, axis_from_tilt, natural_rotation
from controllers.spherical_joint.taut import pair_forces
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.wires import InverseKinematics

_TILT = 1e-3
"""Of the pose that upright is compared with, rad."""
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
    distribution, inverse = TensionDistribution(geometry), InverseKinematics(geometry)
    found = math.inf
    for pair, (agonist, antagonist) in enumerate(((0, 2), (3, 1))):
        axis = axis_from_tilt(_TILT, geometry.anchor_angles[agonist])
        rods, _, _ = inverse.motion(axis, _REST, _REST)
        off = 0.5 * (rods[agonist] - rods[antagonist])
        _, first, second = distribution.at(natural_rotation(axis))
        force = pair_forces(first, second, (tension,) * 4)[pair]
        found = min(found, -force / off)
    return found
