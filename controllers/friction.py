"""Friction as controllers feed it forward: functions of a desired velocity, in plain scalars.

A controller wants a friction model that is smooth where the velocity changes its sign, because
the regulators would have to follow every jump. Two kinds are offered: a static curve that is
rounded over a band of velocities, and one with memory, whose force changes over a distance.
"""

import math

from controllers.compiled import PlainNumbers


class SmoothFriction(PlainNumbers):
    """Static friction of a pair against its velocity, rounded at zero.

    ``F(v) = (Fc + (Fs - Fc) exp(-(v / vs)²)) tanh(v / w) + B v``, an odd function.

    Parameters
    ----------
    coulomb, breakaway : float
        Fc and Fs of the whole pair, N; equal values switch the Stribeck part off.
    stribeck_velocity : float
        vs, m/s.
    viscous : float
        B, N s/m.
    rounding : float
        w, the velocity over which the sign is rounded, m/s.

    References
    ----------
    H. Olsson, K. J. Åström, C. Canudas de Wit, M. Gäfvert, P. Lischinsky, "Friction models and
    friction compensation", Eur. J. Control 4(3), 1998, section 2.
    """

    def __init__(
        self,
        coulomb: float,
        breakaway: float,
        stribeck_velocity: float,
        viscous: float,
        rounding: float,
    ) -> None:
        self._coulomb = coulomb
        self._rise = breakaway - coulomb
        self._per_stribeck = 1.0 / stribeck_velocity
        self._viscous = viscous
        self._per_rounding = 1.0 / rounding

    def force(self, velocity: float) -> float:
        """Return the force that sliding at `velocity` (m/s) takes, N."""
        fade = velocity * self._per_stribeck
        level = self._coulomb + self._rise * math.exp(-fade * fade)
        return level * math.tanh(velocity * self._per_rounding) + self._viscous * velocity


class PreslidingFriction(PlainNumbers):
    """Friction that turns round over a distance, driven by the desired motion.

    Between two surfaces stands a spring that yields (Dahl). Driven by the *desired* velocity it
    says which force the real contact will show there: after a reversal it turns over the
    pre-sliding distance, and at a stop it keeps the force that holds the contact's bristles, so
    that nothing springs back when the motion ends.

    Parameters
    ----------
    coulomb : float
        Force while sliding, N.
    distance : float
        Pre-sliding distance, m: the spring's deflection at that force.
    viscous : float
        N s/m.
    period : float
        The loop's period, s.

    References
    ----------
    P. R. Dahl, "A solid friction model", Aerospace Corp. TOR-158(3107-18), 1968.
    """

    def __init__(self, coulomb: float, distance: float, viscous: float, period: float) -> None:
        self._coulomb = coulomb
        self._viscous = viscous
        self._step = period / distance
        self._share = 0.0

    def reset(self) -> None:
        """Forget the past: no deflection."""
        self._share = 0.0

    def update(self, velocity: float) -> float:
        """Step by one period at `velocity` (m/s) and return the force, N.

        The step is implicit, so that any velocity is stable and the share stays within ±1.
        """
        moved = self._step * velocity
        self._share = (self._share + moved) / (1.0 + abs(moved))
        return self._coulomb * self._share + self._viscous * velocity
