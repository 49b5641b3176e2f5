"""Where the spherical joint may be sent by numbers."""

import math
from collections.abc import Sequence

from controllers.spherical_joint.feasibility import FeasibilityCheck, refuse
from controllers.spherical_joint.poses import axis_from_tilt
from controllers.spherical_joint.types import JointReference
from rig.hal.targets import Targets

_ZERO = (0.0, 0.0, 0.0)


class PoseTargets(Targets[JointReference]):
    """Tilts of the ring's axis and the directions in which it tilts, rad.

    Parameters
    ----------
    check : FeasibilityCheck
        Of poses, against the profile's bounds.
    """

    words = "tilt and azimuth of the ring's axis (rad)"

    def __init__(self, check: FeasibilityCheck) -> None:
        self._check = check

    def rest(self, target: Sequence[float]) -> JointReference:
        """Return the reference to rest in a pose; without an azimuth the tilt is towards +X."""
        tilt, azimuth = target if len(target) > 1 else (*target, 0.0)
        return JointReference(axis_from_tilt(tilt, azimuth), _ZERO, _ZERO)

    def moving(
        self, before: JointReference, here: JointReference, after: JointReference, step: float
    ) -> JointReference:
        """Return the reference of a motion through three poses."""
        steps = list(zip(before.axis, here.axis, after.axis, strict=True))
        u, v, w = [(c - a) / (2.0 * step) for a, _, c in steps]
        du, dv, dw = [(a - 2.0 * b + c) / step**2 for a, b, c in steps]
        return JointReference(here.axis, (u, v, w), (du, dv, dw))

    def distance(self, one: JointReference, other: JointReference) -> float:
        """Return the angle between two axes, rad."""
        (ax, ay, az), (bx, by, bz) = one.axis, other.axis
        across = math.hypot(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
        return math.atan2(across, ax * bx + ay * by + az * bz)

    def check(self, reference: JointReference) -> None:
        """Refuse a pose that is out of reach, slackens a wire or unseats the ring."""
        refuse(self._check.check_pose(reference.axis))
