"""One step of Runge and Kutta's fourth-order method on six joints."""

import math
from collections.abc import Callable

from controllers.arm.types import Joints

LONGEST_STEP = 5e-3
"""s. With it the hand leaves its path by less than 1e-9 m in ten seconds."""


def step_joints(rates: Callable[[float, Joints], Joints], t: float, q: Joints, h: float) -> Joints:
    """Return the joints (rad) after `h` seconds of ``q' = rates(t, q)``."""
    half = 0.5 * h
    k1 = rates(t, q)
    k2 = rates(t + half, _moved(q, k1, half))
    k3 = rates(t + half, _moved(q, k2, half))
    k4 = rates(t + h, _moved(q, k3, h))
    sixth = h / 6.0
    q1, q2, q3, q4, q5, q6 = (
        x + sixth * (a + 2.0 * (b + c) + d) for x, a, b, c, d in zip(q, k1, k2, k3, k4, strict=True)
    )
    return q1, q2, q3, q4, q5, q6


def advance_joints(
    rates: Callable[[float, Joints], Joints], t: float, q: Joints, period: float
) -> Joints:
    """Return the joints after a period, in equal steps no longer than `LONGEST_STEP`."""
    steps = max(1, math.ceil(period / LONGEST_STEP - 1e-9))
    h = period / steps
    for k in range(steps):
        q = step_joints(rates, t + k * h, q, h)
    return q


def _moved(q: Joints, rate: Joints, h: float) -> Joints:
    return (
        q[0] + h * rate[0],
        q[1] + h * rate[1],
        q[2] + h * rate[2],
        q[3] + h * rate[3],
        q[4] + h * rate[4],
        q[5] + h * rate[5],
    )
