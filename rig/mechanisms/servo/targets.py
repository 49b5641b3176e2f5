"""Where servo axes may be sent by numbers."""

from collections.abc import Callable, Sequence
from typing import Generic

from rig.hal.targets import Targets
from rig.mechanisms.servo.axes import AxisLimits, Reference


class AxisTargets(Targets[Reference], Generic[Reference]):
    """Positions of all axes, rad, in the order of the mechanism.

    Parameters
    ----------
    axes : AxisLimits
        Names and limits.
    make : callable
        The mechanism's reference, of positions, velocities, and whether a law follows its path.
    """

    def __init__(self, axes: AxisLimits, make: Callable[..., Reference]) -> None:
        self.words = f"positions of {', '.join(axes.names)} (rad)"
        self._axes = axes
        self._make = make
        self._still = (0.0,) * len(axes.names)

    def rest(self, target: Sequence[float]) -> Reference:
        """Return the reference to rest in a posture."""
        if len(target) != len(self._still):
            raise ValueError
        return self._make(tuple(target), self._still, False)

    def moving(
        self, before: Reference, here: Reference, after: Reference, step: float
    ) -> Reference:
        """Return the reference of a motion through three postures."""
        ways = zip(before.positions, after.positions, strict=True)
        return self._make(here.positions, tuple([(b - a) / (2.0 * step) for a, b in ways]), False)

    def distance(self, one: Reference, other: Reference) -> float:
        """Return the distance of the axis that is farthest off, rad."""
        return max(abs(a - b) for a, b in zip(one.positions, other.positions, strict=True))

    def check(self, reference: Reference) -> None:
        """Refuse what is outside of an axis' range, or faster than it may be."""
        axes = self._axes
        for name, angle, speed, lower, upper, rate in zip(
            axes.names, reference.positions, reference.velocities,
            axes.lower, axes.upper, axes.rates, strict=True,
        ):  # fmt: skip
            if not lower <= angle <= upper:
                raise ValueError(
                    f"{name} at {angle:.4g} rad is outside its range, {lower:.4g} … {upper:.4g} rad"
                )
            if not abs(speed) <= rate:
                raise ValueError(
                    f"{name} at {abs(speed):.4g} rad/s is faster than it may, {rate:.4g} rad/s"
                )
