"""Joint rates that carry the hand along one direction, whatever singularity is near.

They are the null vector of ``[J, -d]``, which is there at ``det J = 0``, too; scaled so that the
joint that is nearest to its rate limit is at it. One speed, 0 … 1, is left: it goes through the
elbow's singularity without any division by S3.
"""

import math

from controllers.arm.on_direction.numbers import FLOOR, Six, TwistNumbers
from controllers.compiled import inlined
from controllers.singularity.two_link import two_link_frame, two_link_parts

_TINY = 1e-9
_CORNER = 0.05
"""Rates that turn by more than this share of a limit within a step are a corner."""
_PIECES = 8
"""Into so many steps a corner is taken apart."""


@inlined
def unit_rates(n: TwistNumbers, q: Six, d: Six, side: float) -> tuple[Six, float]:
    """Return the rates along a direction (rad/s), the fastest joint at its limit.

    Parameters
    ----------
    n : TwistNumbers
        The arm.
    q : tuple of float
        Joints, rad.
    d : tuple of float
        Twist whose direction is meant, m/s and rad/s.
    side : float
        Sign of S3 where the direction was taken: with the other sign the hand goes backwards.

    Returns
    -------
    rates : tuple of float
        Zero if the twist is.
    share : float
        b: the hand then moves with ``share * d``. 0 at the boundary; negative beyond it.

    References
    ----------
    D. N. Nenchev, Y. Tsumaki and M. Uchiyama, "Singularity-consistent parameterization of robot
    motion and control", Int. J. Robotics Research 19(2), 2000: the null vector. Miyata et al.,
    eq. (2)-(6): its entries for this arm.
    """
    c1, s1 = math.cos(q[0]), math.sin(q[0])
    c23, s23 = math.cos(q[1] + q[2]), math.sin(q[1] + q[2])
    c4, s4, c5, s5 = math.cos(q[3]), math.sin(q[3]), math.cos(q[4]), math.sin(q[4])
    lean = n.wrist_sign * s5
    across, along = lean * c4, c23 * lean * c4 + s23 * c5
    ax, ay, az = c1 * along - s1 * lean * s4, s1 * along + c1 * lean * s4, c23 * c5 - s23 * across
    vx = d[0] - n.d6 * (d[4] * az - d[5] * ay)
    vy = d[1] - n.d6 * (d[5] * ax - d[3] * az)
    vz = d[2] - n.d6 * (d[3] * ay - d[4] * ax)
    elbow = q[2] + n.elbow_angle
    frame = two_link_frame(n.a2, n.a3, q[1], elbow)
    out = c1 * vx + s1 * vy
    turn = (c1 * vy - s1 * vx) / _kept_off(frame.radius * frame.sine + n.a1, out)
    swing, stretch, bend = two_link_parts(n.a2, n.a3, frame, out + n.offset * turn, vz)
    e = math.sin(elbow)
    if abs(e) < _TINY:
        e = math.copysign(_TINY, e if e != 0.0 else side)
    r1, r2, r3 = e * turn, e * swing + stretch, bend
    x1, z1 = e * (c1 * d[3] + s1 * d[4]), e * d[5] - r1
    x, y = c23 * x1 - s23 * z1, e * (c1 * d[4] - s1 * d[3]) - (r2 + r3)
    r5 = n.wrist_sign * (c4 * y - s4 * x)
    r6 = n.wrist_sign * (c4 * x + s4 * y) / _kept_off(s5, side * r5)
    r4 = s23 * x1 + c23 * z1 - c5 * r6
    most = max(
        abs(r1) / n.rates[0], abs(r2) / n.rates[1], abs(r3) / n.rates[2],
        abs(r4) / n.rates[3], abs(r5) / n.rates[4], abs(r6) / n.rates[5],
    )  # fmt: skip
    if most == 0.0:
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0.0
    k = side / most
    return (k * r1, k * r2, k * r3, k * r4, k * r5, k * r6), k * e


@inlined
def _kept_off(index: float, leaving: float) -> float:
    """Return an index of singularity, not nearer to zero than `FLOOR`.

    Parameters
    ----------
    index : float
        c or S5.
    leaving : float
        Its speed, whose sign it gets where it is zero.
    """
    if abs(index) >= FLOOR:
        return index
    return math.copysign(FLOOR, index if index != 0.0 else leaving)


@inlined
def moved_on(q: Six, rates: Six, h: float) -> Six:
    """Return joints that went with rates for a time, s."""
    return (
        q[0] + h * rates[0], q[1] + h * rates[1], q[2] + h * rates[2],
        q[3] + h * rates[3], q[4] + h * rates[4], q[5] + h * rates[5],
    )  # fmt: skip


@inlined
def advanced(n: TwistNumbers, q: Six, d: Six, side: float, h: float) -> Six:
    """Return the joints after the hand has gone along a direction at full speed for `h` seconds.

    By a step of Runge and Kutta's method, or several where the joints' path has a corner.
    """
    pieces, after = 1, q
    while True:
        spread, after = 0.0, q
        for _ in range(pieces):
            after, turned = _step(n, after, d, side, h / pieces)
            spread = max(spread, turned)
        if spread <= _CORNER or pieces > 1:
            return after
        pieces = _PIECES


@inlined
def _step(n: TwistNumbers, q: Six, d: Six, side: float, h: float) -> tuple[Six, float]:
    """Return the joints after a step, and by how much the rates turn in it."""
    first = rates = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    after, spread = q, 0.0
    for stage in range(4):
        ahead = 0.5 * h if stage in (1, 2) else h
        rates, _share = unit_rates(n, moved_on(q, rates, ahead), d, side)
        after = moved_on(after, rates, h / (3.0 if stage in (1, 2) else 6.0))
        if stage == 0:
            first = rates
        for j in range(6):
            spread = max(spread, abs(rates[j] - first[j]) / n.rates[j])
    return after, spread
