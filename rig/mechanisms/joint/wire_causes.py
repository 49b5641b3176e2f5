"""Why four rods do not agree on a pose: wires that are softer, or one that is longer.

Four wires over two degrees of freedom leave two residuals at each instant. Both causes are linear
in them, so that the pose is searched for once and its surroundings tell the rest.
"""

import math
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from controllers.spherical_joint.forward import ForwardKinematics
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.pneumatic.diagnosis.causes import Explanation, best_since
from rig.mechanisms.pneumatic.diagnosis.evidence import LastSecond
from rig.mechanisms.pneumatic.diagnosis.words import SLIP, WIRE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_EVERY: Final = 10e-3
"""Poses are searched for so far apart, s."""
_NEAR: Final = 1e-4
"""By so much one wire is changed to see what it does to the others' residuals, m."""
_INDEPENDENT: Final = 20.0
"""Samples a second that tell something of their own."""
_PLAIN: Final = 0.1
"""Share of the permitted residual that healthy wires leave."""
_LIKE: Final = 0.2
"""Stiffness that differs by this share is the profile's."""


def wire_causes(evidence: LastSecond, settings: JointSettings) -> list[Explanation]:
    """Return wires of another stiffness, and one that has become longer.

    Parameters
    ----------
    evidence : LastSecond
        Of the last second.
    settings : JointSettings
        Of the joint.
    """
    step = max(1, round(_EVERY / float(np.median(np.diff(evidence.t)))))
    rows = np.arange(len(evidence.t) - 1, evidence.first - 1, -step)[::-1]
    homes = np.array([settings.home + offset for offset in settings.wire_offsets])
    stretch = settings.area / settings.wire_stiffness * evidence.signals.pressures[rows]
    rods = homes - evidence.signals.extensions[rows] - stretch
    try:
        left, answers = _residuals(settings, rods)
    except ValueError:  # no pose at all explains the rods: the alarm has said so
        return []
    count = max(_INDEPENDENT * evidence.lasts, 2.0)
    noise = (_PLAIN * settings.limits.residual) ** 2
    healthy = _square(left)

    def gain(rest: "Array", parameters: int) -> float:
        ratio = (healthy + noise) / (_square(rest) + noise)
        return count * math.log(ratio) - parameters * math.log(count)

    of_stretch = np.einsum("nij,nj->ni", answers, stretch)
    square = float(np.sum(of_stretch**2))
    softer = float(np.sum(of_stretch * left)) / square if square > 0.0 else 0.0
    found = []
    if 1.0 + softer > 0.0 and abs(softer) > _LIKE:
        stiffness = settings.wire_stiffness / (1.0 + softer)
        found.append(Explanation(WIRE, None, stiffness, gain(left - softer * of_stretch, 1)))

    def longer(wire: int, since: float, parameters: int) -> Explanation:
        shape = answers[:, :, wire] * (evidence.t[rows] >= since)[:, None]
        size = float(np.sum(shape**2))
        by = float(np.sum(shape * left)) / size if size > 0.0 else 0.0
        return Explanation(SLIP, wire, by, gain(left - by * shape, parameters + 1))

    return [*found, *(best_since(evidence, partial(longer, wire)) for wire in range(4))]


def _residuals(settings: JointSettings, rods: "Array") -> "tuple[Array, Array]":
    """Return what rods leave, m, shape (n, 4), and what it changes by with each of them.

    Raises
    ------
    ValueError
        No pose explains them.
    """
    kinematics = ForwardKinematics(settings.geometry)
    kinematics.compile()
    left = np.empty_like(rods)
    answers = np.empty((len(rods), 4, 4))
    for n, four in enumerate(rods):
        first, second, third, fourth = four.tolist()
        left[n] = kinematics.update((first, second, third, fourth)).residuals
        for wire in range(4):
            first, second, third, fourth = (four + _NEAR * (np.arange(4) == wire)).tolist()
            changed = np.array(kinematics.update((first, second, third, fourth)).residuals)
            answers[n, :, wire] = (changed - left[n]) / _NEAR
    return left, answers


def _square(left: "Array") -> float:
    """Return the mean square of residuals over the two lengths that are left, m²."""
    return float(np.mean(np.sum(left**2, axis=1)) / 2.0)
