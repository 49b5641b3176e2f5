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


def pairs_of(profile: Profile, stretch: Stretch) -> list[PairSignals]:
    """Return what the pairs of a ``cylinder`` or ``joint`` did in a stretch.

    A joint's pair moves the ring with more than the difference of its own two tensions wherever
    the ring leans; see `controllers.spherical_joint.tension`.
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
    marker = np.column_stack([stretch[f"estimate.encoder_marker_{axis}"] for axis in "xyz"])
    at = TensionDistribution(settings.geometry).at
    places = np.arange(0, len(marker), _POSE_EVERY)
    poses = [
        at(natural_rotation(tuple((row / np.linalg.norm(row)).tolist()))) for row in marker[places]
    ]
    found = []
    for number, (one, other) in enumerate(PAIRS):
        rows = np.array([(pose.first, pose.second)[number] for pose in poses])
        weights = np.column_stack(
            [np.interp(np.arange(len(marker)), places, rows[:, k]) for k in range(len(channels))]
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
