"""One step of Runge and Kutta's fourth-order method on six joints."""

import math
from collections.abc import Callable

from controllers.arm.types import Joints
from controllers.bisection import bisect
from controllers.compiled import inlined

ROUNDS = 44
"""Halvings of a period, down to the rounding of its end."""

Rates = Callable[[float, Joints], Joints]

LONGEST_STEP = 5e-3
"""s. With it the hand leaves its path by less than 1e-9 m in ten seconds."""


def _step_joints(rates: Rates, t: float, q: Joints, h: float, k1: Joints) -> Joints:
    half = 0.5 * h
    k2 = rates(t + half, moved(q, k1, half))
    k3 = rates(t + half, moved(q, k2, half))
    k4 = rates(t + h, moved(q, k3, h))
    return combined(q, k1, k2, k3, k4, h)


@inlined
def combined(q: Joints, k1: Joints, k2: Joints, k3: Joints, k4: Joints, h: float) -> Joints:
    """Return the joints (rad) a step of `h` seconds on, from the rates at its four places."""
    sixth = h / 6.0
    return (
        q[0] + sixth * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0]),
        q[1] + sixth * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1]),
        q[2] + sixth * (k1[2] + 2.0 * (k2[2] + k3[2]) + k4[2]),
        q[3] + sixth * (k1[3] + 2.0 * (k2[3] + k3[3]) + k4[3]),
        q[4] + sixth * (k1[4] + 2.0 * (k2[4] + k3[4]) + k4[4]),
        q[5] + sixth * (k1[5] + 2.0 * (k2[5] + k3[5]) + k4[5]),
    )


def between(
    q: Joints, rates: Joints, after: Joints, rates_after: Joints, step: float, share: float
) -> Joints:
    """Return the joints (rad) at a share of a step (s) with what is known of both its ends.

    The cubic of Hermite: it misses a fourth derivative times ``step^4 / 384``.
    """
    rest = 1.0 - share
    first, last = rest * rest * (1.0 + 2.0 * share), share * share * (1.0 + 2.0 * rest)
    out, back = step * share * rest * rest, step * share * share * rest
    q1, q2, q3, q4, q5, q6 = (
        first * a + last * b + out * u - back * v
        for a, b, u, v in zip(q, after, rates, rates_after, strict=True)
    )
    return q1, q2, q3, q4, q5, q6


def bisect_period(
    rates: Rates, t: float, q: Joints, period: float, holds: Callable[[float, Joints], bool]
) -> tuple[float, float]:
    """Return between which times into a period (s) a condition stops to hold.

    Parameters
    ----------
    rates, t, q, period
        As for `advance_joints`.
    holds : callable
        Takes the time (s) and the joints (rad) there.
    """

    def holds_after(into: float) -> bool:
        return holds(t + into, advance_joints(rates, t, q, into))

    return bisect(holds_after, 0.0, period, ROUNDS)


def advance_joints(
    rates: Rates, t: float, q: Joints, period: float, now: Joints | None = None
) -> Joints:
    """Return the joints (rad) after a period of ``q' = rates(t, q)``.

    Parameters
    ----------
    rates : callable
        Takes time (s) and joints (rad), returns rad/s.
    t, q : float, tuple of float
        Where it begins, s and rad.
    period : float
        s, done in equal steps no longer than `LONGEST_STEP`.
    now : tuple of float, optional
        ``rates(t, q)`` if it is known: a fifth of the work of a period of one step.
    """
    steps = max(1, math.ceil(period / LONGEST_STEP - 1e-9))
    h = period / steps
    q = _step_joints(rates, t, q, h, rates(t, q) if now is None else now)
    for k in range(1, steps):
        at = t + k * h
        q = _step_joints(rates, at, q, h, rates(at, q))
    return q


@inlined
def moved(q: Joints, rate: Joints, h: float) -> Joints:
    """Return the joints (rad) after `h` seconds at constant rates (rad/s)."""
    return (
        q[0] + h * rate[0],
        q[1] + h * rate[1],
        q[2] + h * rate[2],
        q[3] + h * rate[3],
        q[4] + h * rate[4],
        q[5] + h * rate[5],
    )
