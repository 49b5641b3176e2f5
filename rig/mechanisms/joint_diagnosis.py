"""What is wrong when the four wires of the joint, or its camera, do not agree on a pose."""

import itertools
import math
from collections.abc import Sequence

from controllers.spherical_joint.forward import ForwardKinematics
from controllers.spherical_joint.geometry import Quadruple
from controllers.spherical_joint.poses import Vector

_CLEAR = 0.5
"""An explanation counts if it leaves less than this share of the residual."""
_STILL = 2e-6
"""An encoder that has moved less than this (m) while the others moved is frozen."""


def explain_residual(
    kinematics: ForwardKinematics,
    rods: Quadruple,
    moved: Quadruple,
    names: Sequence[str],
) -> str:
    """Return the likeliest reason why four shortenings fit no pose.

    Parameters
    ----------
    kinematics : ForwardKinematics
        Of this joint; it is left as it was found but for its starting point.
    rods : tuple of float
        Shortening of each wire, m.
    moved : tuple of float
        How far each rod has moved since the wires last agreed, m.
    names : sequence of str
        Of the encoders, in the order of the channels.
    """
    residual = _residual(kinematics, rods)
    still = [k for k, way in enumerate(moved) if abs(way) < _STILL]
    if len(still) == 1 and max(abs(way) for way in moved) > 100.0 * _STILL:
        return f"{names[still[0]]} is frozen"
    for one, other in itertools.combinations(range(4), 2):
        swapped = list(rods)
        swapped[one], swapped[other] = swapped[other], swapped[one]
        if _residual(kinematics, (*swapped,)) < 0.1 * residual:  # type: ignore[arg-type]
            return f"{names[one]} and {names[other]} are swapped"
    left = [_without(kinematics, rods, k) for k in range(4)]
    best = min(range(4), key=lambda k: left[k][0])
    if left[best][0] > _CLEAR * residual:
        return "more than one wire is slack, or the ring is twisted"
    off = left[best][1]
    # Too much shortening: the rod went in further than the ring followed.
    cause = (
        "slack or cut, or its anchor has slipped" if off > 0.0 else "caught, or its encoder is off"
    )
    return f"the wire of ch{best + 1} is {cause}: {abs(off) * 1e3:.2f} mm"


def explain_disagreement(encoders: Vector, camera: Vector, bound: float) -> str:
    """Return the likeliest reason why camera and encoders differ about the marker.

    Parameters
    ----------
    encoders, camera : tuple of float
        Where either puts the marker, m.
    bound : float
        How far they may differ, m.
    """
    x, y, z = camera
    for mirror, seen in (
        ("mirrored left to right", (-x, y, z)),
        ("mirrored top to bottom", (x, -y, z)),
        ("rotated by half a turn", (-x, -y, z)),
        ("rotated by a quarter turn", (-y, x, z)),
        ("rotated by a quarter turn", (y, -x, z)),
    ):
        if math.dist(encoders, seen) < bound:
            return f"the image is {mirror}"
    return "another marker, a slipped anchor, or the calibration of another rig"


def _residual(kinematics: ForwardKinematics, rods: Quadruple) -> float:
    kinematics.reset()
    try:
        return kinematics.update(rods).residual
    except ValueError:
        return math.inf


def _without(kinematics: ForwardKinematics, rods: Quadruple, left_out: int) -> tuple[float, float]:
    """Return the residual that three wires have, and how far the fourth is off their pose, m.

    The fourth is moved to where the others put it; a few rounds suffice, since its residual
    shrinks by a constant share in each.
    """
    adapted = list(rods)
    residuals: Quadruple = (0.0,) * 4
    for _ in range(60):
        kinematics.reset()
        try:
            residuals = kinematics.update((*adapted,)).residuals  # type: ignore[arg-type]
        except ValueError:
            return math.inf, 0.0
        adapted[left_out] -= 2.0 * residuals[left_out]
        if abs(residuals[left_out]) < 1e-7:
            break
    rest = math.sqrt(0.5 * sum(r * r for k, r in enumerate(residuals) if k != left_out))
    return rest, rods[left_out] - adapted[left_out]
