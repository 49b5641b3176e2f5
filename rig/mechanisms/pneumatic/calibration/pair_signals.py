"""A mechanism's antagonistic pairs, each as one force and one position."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.calibration.recording import Stretch
from rig.config import Profile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_POSE_EVERY = 10
"""Samples between two poses of which it is worked out what tensions do there."""


class PairSignals(NamedTuple):
    """One pair in one stretch, sample by sample.

    Parameters
    ----------
    name : str
        Of the pair; empty if there is but one.
    force : ndarray, shape (n,)
        That the chambers put into moving the pair, N.
    position : ndarray, shape (n,)
        m.
    load : ndarray, shape (n,)
        Sum of the two tensions, N.
    """

    name: str
    force: "Array"
    position: "Array"
    load: "Array"


def pairs_of(profile: Profile, stretch: Stretch, axis: "Array | None" = None) -> list[PairSignals]:
    """Return what the pairs of a ``cylinder`` or ``joint`` did in a stretch.

    A joint's pair moves the ring with more than the difference of its own two tensions wherever
    the ring leans; see `controllers.spherical_joint.tension`.

    Parameters
    ----------
    profile, stretch
        Of which rig, and what was recorded.
    axis : ndarray, shape (n, 3), optional
        Of a joint's ring; if it is not given, as the controller made it out from the rods.
    """
    settings = profile.mechanism_settings
    area = settings.area
    if profile.mechanism == "cylinder":
        a, b = (area * stretch[f"reading.pressure_{n}"] for n in ("agonist", "antagonist"))
        return [PairSignals("", a - b, stretch["reading.position"], a + b)]
    from controllers.spherical_joint.geometry import PAIRS
    from controllers.spherical_joint.poses import natural_rotation
    from controllers.spherical_joint.tension import TensionDistribution

    channels = tuple(profile.devices[settings.regulators].settings.channels)
    pull = area * np.column_stack([stretch[f"reading.pressure_{c}"] for c in channels])
    rods = np.column_stack([stretch[f"reading.rod_{c}"] for c in channels])
    if axis is None:
        marker = np.column_stack([stretch[f"estimate.encoder_marker_{name}"] for name in "xyz"])
        axis = marker / np.linalg.norm(marker, axis=1)[:, None]
    at = TensionDistribution(settings.geometry).at
    places = np.arange(0, len(axis), _POSE_EVERY)
    poses = [at(natural_rotation((x, y, z))) for x, y, z in axis[places].tolist()]
    found = []
    for number, (one, other) in enumerate(PAIRS):
        rows = np.array([(pose.first, pose.second)[number] for pose in poses])
        weights = np.column_stack(
            [np.interp(np.arange(len(axis)), places, rows[:, k]) for k in range(len(channels))]
        )
        found.append(
            PairSignals(
                f"pair {one + 1}-{other + 1}",
                (weights * pull).sum(axis=1),
                0.5 * (rods[:, one] - rods[:, other]),
                pull[:, one] + pull[:, other],
            )
        )
    return found
