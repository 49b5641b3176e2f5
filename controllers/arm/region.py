"""The region around the elbow's singularity, and turning back in it without stopping.

Inside the region the command is scaled with an odd function of S3, so that ``b / S3`` and with it
the elbow's rate stay finite: the elbow goes through, b changes sign, and the hand turns back.
"""

import math

from controllers.arm.decomposition import Scale
from controllers.arm.geometry import ArmGeometry
from controllers.bisection import bisect
from controllers.compiled import inlined


@inlined
def turn_back_scale(s3: float, sin_qs: float) -> tuple[float, float]:
    """Return b_v and ``b_v / S3`` for the sine of the elbow's angle.

    Parameters
    ----------
    s3 : float
        S3.
    sin_qs : float
        Half width of the region, sine of the elbow's angle.

    References
    ----------
    Miyata et al., eq. (11): cubic inside, with ``b_v(+-q_s) = +-1`` and zero slope; +-1 outside.
    """
    if abs(s3) <= sin_qs:
        share = s3 / sin_qs
        per_elbow = 0.5 * (3.0 - share * share) / sin_qs
        return per_elbow * s3, per_elbow
    b = 1.0 if s3 > 0.0 else -1.0
    return b, b / s3


@inlined
def pass_scale(index: float, half_width: float) -> float:
    """Return ``|b|`` near the shoulder's or the wrist's singularity, which are passed.

    References
    ----------
    Miyata et al., below eq. (13): these are inside the workspace, so the absolute value is used.
    """
    if half_width == 0.0:
        return 1.0
    b, _ = turn_back_scale(index, half_width)
    return abs(b)


@inlined
def elbow_scale(elbow: float, sin_qs: float, side: float) -> Scale:
    """Return the scale of the commanded twist on a motion that starts on one side.

    Parameters
    ----------
    elbow : float
        The elbow's angle, rad.
    sin_qs : float
        Half width of the region.
    side : float
        Sign of S3 when the motion started; +1 is the paper's law. Without it a command is done
        backwards by an arm that starts with its elbow on the other side.

    Notes
    -----
    The folded arm has ``S3 = 0``, too; there is no region around it.

    References
    ----------
    Miyata et al., section 3: ``w = b_v^2 w_des``, so the sense of turning is kept.
    """
    s3 = math.sin(elbow)
    if math.cos(elbow) > 0.0:
        b, per_elbow = turn_back_scale(s3, sin_qs)
    else:
        b = 1.0 if s3 > 0.0 else -1.0
        per_elbow = b / s3
    return Scale(side * b, b * b, side * per_elbow)


def region_for_speed(geometry: ArmGeometry, speed: float) -> float:
    """Return sin q_s with which a hand of some speed (m/s) does not exceed q3's rate limit.

    References
    ----------
    Miyata et al., eq. (13). It leaves out what turning the tool moves the wrist centre by.
    """
    a2, a3, limit = geometry.a2, geometry.forearm, geometry.rate_limits[2]
    return 3.0 * (a2 + a3) / (2.0 * a2 * a3 * limit) * speed * _steeper(geometry)


def region_for_twist(geometry: ArmGeometry, speed: float, turn_rate: float) -> float:
    """Return sin q_s that is safe for a hand that also turns, whatever the axis.

    Parameters
    ----------
    geometry : ArmGeometry
        Lengths and the rate limit of q3.
    speed, turn_rate : float
        Of the tool, m/s and rad/s.

    Notes
    -----
    With ``u = |S3| / sin q_s`` and ``f = (3 - u^2) / 2`` the elbow's rate is at most
    ``R f (|v| + d6 |w| u f) / (a2 a3 sin q_s)``; eq. (13) is its value at ``u = 0``, which is the
    greatest one only if the tool does not turn. Its slope in u falls from above zero to below it.
    """
    a2, a3, limit = geometry.a2, geometry.forearm, geometry.rate_limits[2]
    swing = geometry.d6 * turn_rate

    def rises(u: float) -> bool:
        square = u * u
        return swing * (9.0 - square * (18.0 - 5.0 * square)) > 4.0 * speed * u

    u = bisect(rises, 0.0, 1.0)[0] if swing else 0.0
    f = 0.5 * (3.0 - u * u)
    return (a2 + a3) / (a2 * a3 * limit) * f * (speed + swing * u * f) * _steeper(geometry)


def region_for_acceleration(geometry: ArmGeometry, speed: float) -> float:
    """Return sin q_s with which q3 stays within its acceleration limit on a radial line.

    Notes
    -----
    In a small region the elbow accelerates by up to ``K^2 / sin^3 q_s``, ``K = v R / (a2 a3)``.
    """
    a2, a3 = geometry.a2, geometry.forearm
    k = speed * (a2 + a3) / (a2 * a3)
    return math.cbrt(k * k / geometry.acceleration_limits[2])


def least_rate(geometry: ArmGeometry, speed: float) -> float:
    """Return the rate limit of q3 (rad/s) below which no region is wide enough for the speed.

    References
    ----------
    Miyata et al., eq. (13) with ``sin q_s = 1``.
    """
    a2, a3 = geometry.a2, geometry.forearm
    return 3.0 * (a2 + a3) * speed / (2.0 * a2 * a3) * _steeper(geometry)


def _steeper(geometry: ArmGeometry) -> float:
    """Return how much faster than the hand the wrist may get away from the shoulder.

    With a shoulder offset d the wrist is ``sqrt(r_s² + d²)`` from the shoulder's axis where the
    arm's plane has it at ``r_s``: the gradient of ``r_s`` is that much longer than 1.
    """
    return math.hypot(1.0, geometry.shoulder_offset / geometry.reach)
