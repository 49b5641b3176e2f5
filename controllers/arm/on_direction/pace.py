"""How fast the hand may go along its direction: always so that it can still come to rest.

Every period is taken only if from its end the joints can be brought to rest along the same
direction, within their accelerations and ranges. The first step of that way to rest is what is
left whenever nothing better is possible, so it is always there.
"""

import math

from controllers.arm.on_direction.direction import advanced, unit_rates
from controllers.arm.on_direction.numbers import Six, TwistNumbers
from controllers.compiled import inlined

Step = tuple[bool, float, Six, Six, float]
"""Whether it can be, the speed 0 … 1, the joints after it (rad), its mean rates (rad/s), and with
how much of what is asked for the hand goes."""

_ROOM = 0.998
"""Share of the accelerations that is used: the rest is for the search."""
_ROUNDS = 3
_EDGE = 1e-9
"""rad, and of S3."""
_SURFACE = 1e-4
"""c (m) at which the hand stands before the void round the axis of q1: 0.1 um from it and less."""
_REST = 1e-12
_HALVINGS = 4
_FINE = 1e-3
"""Speeds are not told apart more finely."""
_ABOVE = 0.02
"""Of the speed that is asked for, by which the hand may be faster."""
_LEAST_PART = 1.0 / 64.0
"""Of the way to a new direction is tried; the whole first, and then half of it each time."""


@inlined
def _window(n: TwistNumbers, m: Six, u: Six) -> tuple[float, float]:
    """Return the speeds between which no joint is accelerated too much."""
    low, high = 0.0, 1.0
    for j in range(6):
        most = _ROOM * n.steps[j]
        if abs(m[j]) > _REST:
            one, other = (u[j] - most) / m[j], (u[j] + most) / m[j]
            low, high = max(low, min(one, other)), min(high, max(one, other))
        elif abs(u[j]) > most:
            high = -1.0
    return low, high


@inlined
def _step_at(n: TwistNumbers, q: Six, d: Six, side: float, u: Six, wanted: float) -> Step:
    """Return the period along a direction whose speed is nearest to the wanted one.

    Parameters
    ----------
    n : TwistNumbers
        The arm.
    q, u : tuple of float
        Joints (rad), and their mean rates in the period before (rad/s).
    d, side
        See `unit_rates`.
    wanted : float
        0: as slow as can be.
    """
    dt = n.period
    m, share = unit_rates(n, q, d, side)
    speed, after = 0.0, q
    for _ in range(_ROUNDS):
        low, high = _window(n, m, u)
        if high < 0.0:
            low = high = 0.0
        speed = min(max(wanted, low), high) if low <= high else min(0.5 * (low + high), 1.0)
        if speed * dt < _REST:
            speed, after = 0.0, q
            break
        after = advanced(n, q, d, side, speed * dt)
        h = speed * dt
        m = (
            (after[0] - q[0]) / h, (after[1] - q[1]) / h, (after[2] - q[2]) / h,
            (after[3] - q[3]) / h, (after[4] - q[4]) / h, (after[5] - q[5]) / h,
        )  # fmt: skip
    rates = (
        (after[0] - q[0]) / dt, (after[1] - q[1]) / dt, (after[2] - q[2]) / dt,
        (after[3] - q[3]) / dt, (after[4] - q[4]) / dt, (after[5] - q[5]) / dt,
    )  # fmt: skip
    return _permitted(n, q, after, side, u, rates), speed, after, rates, speed * abs(share)


@inlined
def _permitted(n: TwistNumbers, q: Six, after: Six, side: float, u: Six, rates: Six) -> bool:
    """Return whether a period keeps accelerations, rates and ranges, and no boundary is passed."""
    for j in range(6):
        if abs(rates[j] - u[j]) > n.steps[j]:
            return False
        if abs(rates[j]) > n.rates[j] * (1.0 + _EDGE):
            return False
        # Who is out of its range may come back.
        if after[j] > n.upper[j] + _EDGE and after[j] > q[j]:
            return False
        if after[j] < n.lower[j] - _EDGE and after[j] < q[j]:
            return False
    s3 = math.sin(after[2] + n.elbow_angle)
    if not n.through and side * s3 < -_EDGE:
        return False
    if n.offset != 0.0:  # the axis of q1 is in a void, whose surface is a boundary
        before, c = _radius(n, q), _radius(n, after)
        return before * c >= 0.0 and (abs(c) >= _SURFACE or abs(c) >= abs(before))
    return True


@inlined
def _radius(n: TwistNumbers, q: Six) -> float:
    return n.a2 * math.sin(q[1]) + n.a3 * math.sin(q[1] + q[2] + n.elbow_angle) + n.a1


@inlined
def _comes_to_rest(n: TwistNumbers, q: Six, d: Six, side: float, u: Six) -> bool:
    """Return whether the joints can be brought to rest along a direction.

    On that way the hand is no faster than it is asked to be: back from the boundary the joints'
    rates are soon more than that.
    """
    for _ in range(int(n.horizon)):
        can, speed, q, u, share = _step_at(n, q, d, side, u, 0.0)
        if not can or share > 1.0 + _ABOVE:
            return False
        if speed == 0.0:
            return True
    return False


@inlined
def _fastest(n: TwistNumbers, q: Six, d: Six, side: float, u: Six) -> Step:
    """Return the fastest period along a direction from which the joints come to rest."""
    _m, share = unit_rates(n, q, d, side)
    most = 1.0 / abs(share) if abs(share) > 1.0 else 1.0
    found, low, high = False, 0.0, 0.0
    best: Step = (False, 0.0, q, u, 0.0)
    for tries in range(_HALVINGS + 2):
        # As fast as asked for; as slow as can be; then what is between.
        wanted = most if tries == 0 else 0.0 if tries == 1 else 0.5 * (low + high)
        tried = _step_at(n, q, d, side, u, wanted)
        if tries == 0:
            high = tried[1]
        slow = tried[4] <= 1.0 + _ABOVE
        if tried[0] and slow and _comes_to_rest(n, tried[2], d, side, tried[3]):
            found, low, best = True, tried[1], tried
            if tries == 0:
                break
        elif tries == 1:
            break
        else:
            high = wanted if tries > 1 else high
        if high - low < _FINE:
            break
    return (found, best[1], best[2], best[3], best[4])


@inlined
def _is_along(d: Six, asked: Six, dot: float) -> bool:
    """Return whether a twist has the direction that is followed, or none is."""
    one = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[3] * d[3] + d[4] * d[4] + d[5] * d[5]
    other = (
        asked[0] * asked[0] + asked[1] * asked[1] + asked[2] * asked[2]
        + asked[3] * asked[3] + asked[4] * asked[4] + asked[5] * asked[5]
    )  # fmt: skip
    return one == 0.0 or (dot > 0.0 and dot * dot >= (1.0 - 1e-12) * one * other)


@inlined
def _blended(share: float, d: Six, part: float, asked: Six) -> Six:
    a = (1.0 - part) * share
    return (
        a * d[0] + part * asked[0], a * d[1] + part * asked[1], a * d[2] + part * asked[2],
        a * d[3] + part * asked[3], a * d[4] + part * asked[4], a * d[5] + part * asked[5],
    )  # fmt: skip


@inlined
def next_period(
    n: TwistNumbers, q: Six, u: Six, d: Six, side: float, share: float, asked: Six
) -> tuple[Six, Six, Six, float, float]:
    """Return the joints at the end of a period in which a twist is asked for.

    Parameters
    ----------
    n : TwistNumbers
        The arm.
    q, u : tuple of float
        Joints at its beginning (rad), mean rates of the period before (rad/s).
    d, side, share
        Direction that was followed (m/s, rad/s), its side, and how much of it was done.
    asked : tuple of float
        Twist, base axes, m/s and rad/s; zero: come to rest.

    Returns
    -------
    q, u, d : tuple of float
        At its end.
    side, share : float
        At its end.
    """
    size = max(
        abs(asked[0]), abs(asked[1]), abs(asked[2]), abs(asked[3]), abs(asked[4]), abs(asked[5])
    )
    s3 = math.sin(q[2] + n.elbow_angle)
    if size > 0.0:
        dot = (
            d[0] * asked[0] + d[1] * asked[1] + d[2] * asked[2]
            + d[3] * asked[3] + d[4] * asked[4] + d[5] * asked[5]
        )  # fmt: skip
        new = side if dot > 0.0 or abs(s3) < _EDGE else math.copysign(1.0, s3)
        part, least = 1.0, 1.0 if _is_along(d, asked, dot) else _LEAST_PART
        while part >= least:
            tried = asked if part == 1.0 else _blended(abs(share), d, part, asked)
            can, speed, after, rates, _share = _fastest(n, q, tried, new, u)
            if can:
                _m, b = unit_rates(n, q, tried, new)
                return after, rates, tried, new, speed * b
            part *= 0.5
    _can, speed, after, rates, _share = _step_at(n, q, d, side, u, 0.0)
    _m, b = unit_rates(n, q, d, side)
    if speed == 0.0:
        side = math.copysign(1.0, s3) if abs(s3) > _EDGE else side
        d = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return after, rates, d, side, speed * b
