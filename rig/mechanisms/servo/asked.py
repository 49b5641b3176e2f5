"""What a controller may ask of servo axes."""

import math
from collections.abc import Sequence
from typing import Final

from rig.hal import SafetyError, Vector

_LEEWAY: Final = 2.0
"""A command may go so many times as far in a period as its axis at its greatest speed, beside the
way of the reference itself. Every shipped law but the plain inverse asks for 1.0 of that speed at
most; that one asks for 63 beside a singularity, and so does its reference."""


class AskedPositions:
    """The positions that a controller has asked for, and how far the next ones may be.

    A clamp would lead the axes away from their path, each as fast as it can, until something
    goes wrong that is not the controller. So what neither an axis nor the reference explains is
    a fault at once.

    Parameters
    ----------
    names : sequence of str
        Of the axes.
    rates : sequence of float
        Their greatest speeds, rad/s.
    following : float
        How far an axis may be from where it was sent, rad. The first command may start from
        where the axes are.
    period : float
        Of the cycle, s.
    """

    def __init__(
        self, names: Sequence[str], rates: Sequence[float], following: float, period: float
    ) -> None:
        self._names = tuple(names)
        self._reaches = tuple([_LEEWAY * rate * period for rate in rates])
        self._following = following
        self.restart((0.0,) * len(self._names))

    def restart(self, positions: Vector) -> None:
        """Expect the next command to start from here, rad."""
        self._asked = positions
        self._slack = self._following
        self._reference: Vector | None = None
        self._steps: Vector = (0.0,) * len(self._names)

    def check(self, reference: Vector, asked: Vector) -> None:
        """Raise if a command jumps.

        The bound is the way at `_LEEWAY` times the greatest speed, and the step of the
        reference: of this period, or of the one before where a late cycle has shifted it.

        Parameters
        ----------
        reference : tuple of float
            Where the axes should be, rad.
        asked : tuple of float
            Where the controller wants them to go, rad.

        Raises
        ------
        SafetyError
            It names the axis, by how much its command jumps, and by how much it might.
        """
        before = self._reference or reference
        steps = tuple([abs(b - a) for a, b in zip(before, reference, strict=True)])
        for k, wanted in enumerate(asked):
            jump = wanted - self._asked[k]
            most = self._reaches[k] + max(steps[k], self._steps[k]) + self._slack
            if not -most <= jump <= most:
                what = f"jumps by {jump:.4g}" if math.isfinite(jump) else f"is {wanted}"
                raise SafetyError(
                    f"the controller's command of {self._names[k]} {what} rad, "
                    f"at most {most:.4g} rad in a period is allowed"
                )
        self._asked, self._reference, self._steps = asked, reference, steps
        self._slack = 0.0
