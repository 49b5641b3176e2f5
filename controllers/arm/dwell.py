"""Staying in a region around the elbow's singularity for a given time.

With the tool's direction kept and ``b(t)`` given over time, the elbow's way through the region is
fixed by the integral of b alone. It has to be I; how b gets there is free.
"""

import math
from typing import Literal, NamedTuple

from controllers.arm.kinematics import Dimensions
from controllers.motion import InfeasibleMotion
from controllers.rounding import floor

_LEAST = 0.6
"""Share of the constant of a dwell without ramps that one with ramps keeps at least."""


_STEPS = 400
"""Of the first half of a dwell, when its elbow's peak is looked for."""


class Switch(NamedTuple):
    """b and its rate where the hand enters the region; it leaves with ``b, -rate``.

    Parameters
    ----------
    b : float
        ``v_z / (a2 a3 S3)``, 1/(m s).
    rate : float
        Its time derivative, 1/(m s²).
    """

    b: float
    rate: float


def elbow_at_depth(arm: Dimensions, depth: float) -> float:
    """Return q_s, the elbow's angle (rad) where the wrist is `depth` (m) inside the boundary.

    Raises
    ------
    InfeasibleMotion
        So deep the arm is folded, or it does not get there at all.

    Notes
    -----
    The paper's text swaps the two: q_s is in joint space, d_s in the workspace.

    References
    ----------
    Miyata et al., eq. (18).
    """
    a2, a3 = arm.a2, arm.a3
    folded = 2.0 * min(a2, a3)
    if depth >= folded:
        raise InfeasibleMotion(
            f"a depth of {depth:g} m is no less than {folded:g} m, at which the arm is folded: "
            f"there is no such region."
        )
    square = depth * depth + 2.0 * a2 * a3 - 2.0 * depth * (a2 + a3)
    return math.acos(square / (2.0 * a2 * a3))


def integral_taylor(arm: Dimensions, q_s: float) -> float:
    """Return I with the cosine cut after its square; Miyata et al., eq. (19), s m."""
    root = math.sqrt(arm.a2 * arm.a3)
    return 2.0 / root * math.asin(root / (arm.a2 + arm.a3) * q_s)


def integral_exact(arm: Dimensions, q_s: float) -> float:
    """Return I without the Taylor expansion, ``(4 / R) F(q_s / 2 | 4 a2 a3 / R^2)``, s m.

    References
    ----------
    Miyata et al., eq. (17) before its expansion: an elliptic integral of the first kind.
    """
    from scipy.special import ellipkinc

    reach = arm.a2 + arm.a3
    return float(4.0 / reach * ellipkinc(0.5 * q_s, 4.0 * arm.a2 * arm.a3 / reach**2))


def switch_of(
    arm: Dimensions, q_s: float, speed: float, cosine: float, bend: float | None = None
) -> Switch:
    """Return b and b' of a hand that enters at constant speed along a line.

    Parameters
    ----------
    arm : Dimensions
        The arm.
    q_s : float
        The elbow's angle there, rad.
    speed : float
        m/s.
    cosine : float
        Of the angle between the line and the wrist's direction from the shoulder.
    bend : float, optional
        How it changes along the line, 1/m; None: as before a boundary that is a sphere.
    """
    a2a3, s3, c3 = arm.a2 * arm.a3, math.sin(q_s), math.cos(q_s)
    radius = math.sqrt(arm.a2**2 + arm.a3**2 + 2.0 * a2a3 * c3)
    radial = speed * cosine
    b = radial / (a2a3 * s3)
    q3_rate = -radius * b
    if bend is None:
        radial_rate = speed * speed * (1.0 - cosine * cosine) / radius
    else:
        radial_rate = speed * speed * bend
    return Switch(b, (radial_rate - radial * c3 / s3 * q3_rate) / (a2a3 * s3))


def longest_quintic(integral: float, switch: Switch) -> float:
    """Return t_s,max (s): beyond it the quintic stops and reverses the arm within the region."""
    b, rate = switch
    if rate == 0.0:
        return 15.0 * integral / (7.0 * b)
    return (-7.0 * b + math.sqrt(49.0 * b * b + 30.0 * rate * integral)) / rate


class QuinticDwell:
    """b(t) of the paper: its integral is a quintic, so it is a polynomial of the fourth degree.

    Parameters
    ----------
    integral : float
        I, s m.
    duration : float
        t_s, s.
    switch : Switch
        Values where the region is entered. They hold, mirrored, where it is left.

    References
    ----------
    Miyata et al., eq. (16) and the text below (19).
    """

    def __init__(self, integral: float, duration: float, switch: Switch) -> None:
        self.duration = duration
        self._half = 0.5 * duration
        b, rate = switch
        self.middle = (15.0 * integral / duration - 7.0 * b - 0.5 * rate * duration) / 8.0
        """b half way: the least one. Not above zero: the arm stops and goes back."""
        # b = m + p x + q x^2 with x = (t - half)^2: mirrored, b and slope met at both ends.
        h2 = self._half**2
        rise, slope = b - self.middle, -rate * self._half / 2.0
        self._q = (slope - rise) / h2**2
        self._p = (2.0 * rise - slope) / h2

    def at(self, t: float) -> float:
        """Return b at `t` seconds since the region was entered."""
        x = (t - self._half) ** 2
        return self.middle + x * (self._p + x * self._q)

    def covered(self, t: float) -> float:
        """Return the integral of b over the first `t` seconds."""
        return self._odd(t - self._half) + self._odd(self._half)

    def _odd(self, u: float) -> float:
        x = u * u
        return u * (self.middle + x * (self._p / 3.0 + x * self._q / 5.0))


class RampDwell:
    """b(t) that never stops: a cubic ramp down, a constant, and the ramp mirrored.

    Parameters
    ----------
    integral : float
        I, s m.
    duration : float
        t_s, s.
    switch : Switch
        Values where the region is entered.

    Notes
    -----
    The constant is ``(I - b0 T - b0' T^2 / 6) / (t_s - T)`` for a ramp of T seconds: T is the
    longest one that leaves `_LEAST` of what it is without ramps, and at most a quarter of the
    dwell.
    """

    def __init__(self, integral: float, duration: float, switch: Switch) -> None:
        self.duration = duration
        self._switch = switch
        mean = integral / duration
        ramp = 0.25 * duration
        while self._constant(integral, ramp) < _LEAST * mean:
            ramp *= 0.95
        self._ramp = ramp
        self.middle = self._constant(integral, ramp)
        """b between the ramps."""

    def _constant(self, integral: float, ramp: float) -> float:
        b, rate = self._switch
        return (integral - b * ramp - rate * ramp * ramp / 6.0) / (self.duration - ramp)

    def at(self, t: float) -> float:
        """Return b at `t` seconds since the region was entered."""
        into = min(t, self.duration - t)
        if into >= self._ramp:
            return self.middle
        b, rate = self._switch
        x = into / self._ramp
        blend = x * x * (3.0 - 2.0 * x)
        return b + (self.middle - b) * blend + rate * self._ramp * x * (1.0 - x) ** 2


def elbow_peak(
    arm: Dimensions, q_s: float, profile: QuinticDwell | RampDwell
) -> tuple[float, float]:
    """Return when the elbow is fastest within the region, s since it was entered, and how fast.

    The rate, rad/s, is positive. It is soon after the border, within the first half.

    Notes
    -----
    ``q3' = r_s b(t)``: one equation, in steps that are the shorter the nearer to the border.
    """

    def rate(t: float, angle: float) -> float:
        radius = math.sqrt(arm.a2**2 + arm.a3**2 + 2.0 * arm.a2 * arm.a3 * math.cos(angle))
        return radius * abs(profile.at(t))

    angle, last, peak = q_s, 0.0, (0.0, rate(0.0, q_s))
    for k in range(1, _STEPS + 1):
        t = 0.5 * profile.duration * (k / _STEPS) ** 4
        half = 0.5 * (t - last)
        middle = angle - half * rate(last, angle)
        angle -= 2.0 * half * rate(last + half, middle)
        last, peak = t, max(peak, (t, rate(t, angle)), key=lambda its: its[1])
    return peak


def make_dwell(
    profile: Literal["quintic", "ramp"],
    integral: float,
    duration: float,
    switch: Switch,
) -> QuinticDwell | RampDwell:
    """Return b(t), if it does not stop the arm.

    Raises
    ------
    InfeasibleMotion
        The quintic would stop and reverse the arm; the longest dwell is named.
    """
    if profile == "ramp":
        return RampDwell(integral, duration, switch)
    dwell = QuinticDwell(integral, duration, switch)
    if dwell.middle <= 0.0:
        longest = longest_quintic(integral, switch)
        raise InfeasibleMotion(
            f"a dwell of {duration:g} s would stop and reverse the arm in the region: b reaches "
            f"{dwell.middle:.4g}; at this speed and depth a quintic dwells at most "
            f"{floor(longest):g} s. A slower hand dwells for longer; esc has no such bound."
        )
    return dwell
