"""The smoothest motion from rest to rest."""


def minimum_jerk(start: float, end: float, duration: float, t: float) -> tuple[float, float, float]:
    """Return the motion from rest to rest that minimises the integral of squared jerk.

    Parameters
    ----------
    start, end : float
        Positions, m or rad.
    duration : float
        s; outside 0 … `duration` the motion rests at its ends.
    t : float
        s.

    Returns
    -------
    position, velocity, acceleration : float
        m, m/s, m/s² or rad, rad/s, rad/s².

    References
    ----------
    T. Flash, N. Hogan, J. Neurosci. 5(7), 1985: the fifth-order polynomial.
    """
    if t <= 0.0:
        return start, 0.0, 0.0
    if t >= duration:
        return end, 0.0, 0.0
    s = t / duration
    travel = end - start
    return (
        start + travel * s**3 * (10.0 - 15.0 * s + 6.0 * s * s),
        travel / duration * 30.0 * s * s * (1.0 - s) ** 2,
        travel / duration**2 * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
    )
