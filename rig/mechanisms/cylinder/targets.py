"""Where one antagonistic pair may be sent by a number."""

from collections.abc import Sequence

from controllers.cylinder.types import PairReference
from rig.hal.targets import Targets
from rig.mechanisms.cylinder.settings import CylinderLimits


class PairTargets(Targets[PairReference]):
    """Positions of the pair, m.

    Parameters
    ----------
    limits : CylinderLimits
        Of the profile.
    """

    words = "position of the pair (m)"

    def __init__(self, limits: CylinderLimits) -> None:
        self._limits = limits

    def rest(self, target: Sequence[float]) -> PairReference:
        """Return the reference to rest at a position."""
        (position,) = target
        return PairReference(position, 0.0, 0.0)

    def moving(
        self, before: PairReference, here: PairReference, after: PairReference, step: float
    ) -> PairReference:
        """Return the reference of a motion through three positions."""
        a, b, c = before.position, here.position, after.position
        return PairReference(b, (c - a) / (2.0 * step), (a - 2.0 * b + c) / step**2)

    def distance(self, one: PairReference, other: PairReference) -> float:
        """Return the distance of two positions, m."""
        return abs(one.position - other.position)

    def check(self, reference: PairReference) -> None:
        """Refuse what is outside of the limits on position and speed."""
        (lower, upper), speed = self._limits.position, self._limits.speed
        if not lower <= reference.position <= upper:
            raise ValueError(
                f"{reference.position * 1e3:.4g} mm is outside limits.position, "
                f"{lower * 1e3:.4g} … {upper * 1e3:.4g} mm"
            )
        if not abs(reference.velocity) <= speed:
            raise ValueError(
                f"{abs(reference.velocity) * 1e3:.4g} mm/s is more than limits.speed, "
                f"{speed * 1e3:.4g} mm/s"
            )
