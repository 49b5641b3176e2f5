"""The constants of an arm that a step of an online law is computed with."""

import math

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.compiled import PlainNumbers

Six = tuple[float, float, float, float, float, float]
"""A value per joint, or a twist: velocity (m/s) and angular velocity (rad/s)."""

FLOOR = 1e-6
"""c (m) and S5 are not taken for less: a hand that passes nearer goes straight on."""
_HORIZON = 6.0
"""A way to rest may take so many times as long as the slowest joint alone needs."""


class TwistNumbers(PlainNumbers):
    """Dimensions and limits of an arm, and the period.

    Parameters
    ----------
    geometry : ArmGeometry
        The arm.
    period : float
        s.
    through : bool
        Whether the elbow may go through its singularity: the hand then comes back from the
        boundary of the workspace on the line on which it got there.
    rest : int, optional
        Within how many periods the hand has to be able to come to rest.
    """

    def __init__(
        self, geometry: ArmGeometry, period: float, *, through: bool, rest: int | None = None
    ) -> None:
        arm = dimensions_of(geometry)
        self.a1, self.a2, self.a3, self.d6 = arm.a1, arm.a2, arm.a3, arm.d6
        self.offset, self.elbow_angle, self.wrist_sign = (
            arm.offset, arm.elbow_angle, arm.wrist_sign,
        )  # fmt: skip
        self.period, self.through = period, through
        self.rates = geometry.rate_limits
        self.steps = tuple([period * limit for limit in geometry.acceleration_limits])
        """Greatest change of each joint's rate in a period, rad/s."""
        self.lower, self.upper = geometry.position_min, geometry.position_max
        slowest = max(rate / step for rate, step in zip(self.rates, self.steps, strict=True))
        longest = math.ceil(_HORIZON * slowest) + 10
        self.horizon = float(longest if rest is None else min(longest, rest + 1))
        """Periods that a way to rest may take, with the one in which the hand stands."""
