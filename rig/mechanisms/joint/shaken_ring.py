"""What a shake of the ring does to the pair that moves it."""

import numpy as np

from controllers.spherical_joint.geometry import PAIRS, SphericalJointGeometry
from controllers.spherical_joint.poses import natural_rotation
from controllers.spherical_joint.tension import TensionDistribution
from rig.calibration.arrays import between_rows
from rig.hal.measured_loop import Array

_POSE_EVERY = 10
"""Samples between two poses for which the distribution of tensions is worked out."""


def shaken_signals(
    geometry: SphericalJointGeometry, axis: Array, rods: Array, sent: Array, read: Array
) -> Array:
    """Return what is sent to a pair and read of it, as its law does: see `ShakenPair`.

    The pair is the one that moves more.

    Parameters
    ----------
    geometry : SphericalJointGeometry
        Where the wires lie.
    axis : ndarray, shape (n, 3)
        The ring's, of any length.
    rods : ndarray, shape (n, 4)
        How far each is pulled in, m.
    sent, read : ndarray, shape (n, 4)
        Setpoints and pressures, Pa.

    Returns
    -------
    ndarray, shape (n, 3)
        Force of the pair that is asked for, over the area (Pa); its place (m); the same force as
        the monitors have it (Pa).
    """
    places = [0.5 * (rods[:, one] - rods[:, other]) for one, other in PAIRS]
    number = int(np.argmax([np.ptp(place) for place in places]))
    unit = axis / np.linalg.norm(axis, axis=1)[:, None]
    at = TensionDistribution(geometry).at
    rows = np.arange(0, len(axis), _POSE_EVERY)
    poses = [at(natural_rotation((x, y, z))) for x, y, z in unit[rows].tolist()]
    found = np.array([(pose.first, pose.second)[number] for pose in poses])
    weights = between_rows(found, rows, np.arange(len(axis)))
    pulls = ((weights * pressures).sum(axis=1) for pressures in (sent, read))
    return np.column_stack([next(pulls), places[number], next(pulls)])
