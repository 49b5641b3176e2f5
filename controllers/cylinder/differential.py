"""From one differential pressure to the setpoints of both cylinders, within their range.

Controllers of a pair command the difference of the two pressures; the mean stays at the
co-contraction base pressure. What they need to know for anti-windup is how much of a wish can be
had: `DifferentialRange` for a static wish, `RegulatorLead` for one that has to get through the
regulators' dynamics.
"""

import math

from controllers.compiled import PlainNumbers
from controllers.cylinder.types import PairModel
from controllers.motion import InfeasibleMotion


class DifferentialRange(PlainNumbers):
    """The differential that both chambers can take around the base pressure, and its split.

    Parameters
    ----------
    model : PairModel
        Range of the regulators and base pressure.
    floor : float
        No setpoint goes below, Pa gauge: a wire without pressure goes slack.
    most : float, optional
        Greatest differential wanted either way, Pa. Where one chamber has come down to the floor,
        the other goes on alone and the mean gives way. None: the mean never does.

    Raises
    ------
    InfeasibleMotion
        The base pressure leaves no room above the floor, or below the top of the range.
    """

    def __init__(self, model: PairModel, floor: float, most: float | None = None) -> None:
        lower = max(floor, model.pressure_min)
        above = model.pressure_max - model.base_pressure
        half = min(model.base_pressure - lower, above)
        if half <= 0.0:
            raise InfeasibleMotion(
                f"base_pressure ({model.base_pressure:g} Pa) leaves no differential between the "
                f"pressure floor ({lower:g} Pa) and the most of limits.pressure "
                f"({model.pressure_max:g} Pa)."
            )
        self._base = model.base_pressure
        self._floor = lower
        self.limit = 2.0 * half if most is None else min(most, model.pressure_max - lower)
        """Greatest differential either way, Pa."""

    def clip(self, differential: float) -> float:
        """Return the nearest differential (Pa) that both chambers can take."""
        limit = self.limit  # compared, because min() and max() take five times as long
        return -limit if differential < -limit else limit if differential > limit else differential

    def share(self, differential: float) -> tuple[float, float]:
        """Return the setpoints for the nearest differential that both chambers can take, Pa."""
        limit = self.limit
        if differential < -limit:
            differential = -limit
        elif differential > limit:
            differential = limit
        half = 0.5 * differential
        base, lifted = self._base, self._floor + abs(half)
        mean = lifted if lifted > base else base
        return mean + half, mean - half


class RegulatorLead(PlainNumbers):
    """Inverse of the regulators' dynamics behind a faster low-pass, with head-room.

    The wish ``u`` goes through a critically damped low-pass of bandwidth ``wl`` that gives it two
    smooth derivatives; the setpoint ``f + 2 zeta/w f' + f''/w²`` then makes a regulator of
    bandwidth ``w`` put out ``f``. Where that setpoint does not fit the range, the low-pass is
    slowed down by what is missing, so ``f`` remains what the regulators can really do: there is
    nothing to wind up.

    Parameters
    ----------
    model : PairModel
        Bandwidth and damping of the regulators.
    bandwidth : float
        Of the low-pass, rad/s. Its square over that of the regulators is the gain on noise.
    limit : float
        Greatest setpoint differential either way, Pa.
    period : float
        The loop's period, s.

    Notes
    -----
    On the simulated pair, bandwidths of 540 to 730 rad/s are good and 60 rad/s is unstable.
    """

    def __init__(self, model: PairModel, bandwidth: float, limit: float, period: float) -> None:
        decay = math.exp(-bandwidth * period)
        # Exact step of the critically damped low-pass, in terms of its distance g = f - u:
        # g' = gg g + gf f', f'' likewise.
        self._gg = decay * (1.0 + bandwidth * period)
        self._gf = decay * period
        self._fg = -decay * bandwidth * bandwidth * period
        self._ff = decay * (1.0 - bandwidth * period)
        self._rate_gain = 2.0 * model.regulator_damping / model.regulator_bandwidth
        self._jerk_gain = 1.0 / (model.regulator_bandwidth**2 * period)
        self._limit = limit
        # The setpoint that acts over a period matches the means of f, f' and f'' over it; it is
        # linear in u with this slope.
        self._slope = (
            0.5 * (1.0 - self._gg) - 0.5 * self._rate_gain * self._fg - self._jerk_gain * self._fg
        )
        self.pressure = 0.0
        """The differential that the regulators should have at the end of the period, Pa."""
        self.rate = 0.0
        """Its rate, Pa/s."""
        self.saturation = 0
        """Side on which the last setpoint hit the limit: -1, 0 or 1."""

    def reset(self, differential: float) -> None:
        """Start at rest at a measured differential, Pa."""
        self.pressure = min(max(differential, -self._limit), self._limit)
        self.rate = 0.0
        self.saturation = 0

    def update(self, wish: float) -> float:
        """Return the setpoint differential (Pa) towards the wished one (Pa)."""
        before, rate_before = self.pressure, self.rate
        gap = before - wish
        pressure = wish + self._gg * gap + self._gf * rate_before
        rate = self._fg * gap + self._ff * rate_before
        setpoint = (
            0.5 * (before + pressure)
            + 0.5 * self._rate_gain * (rate_before + rate)
            + self._jerk_gain * (rate - rate_before)
        )
        limit = self._limit
        self.saturation = saturation = 1 if setpoint > limit else -1 if setpoint < -limit else 0
        if saturation:  # slower, so that the setpoint is on the limit
            wish += (saturation * limit - setpoint) / self._slope
            setpoint = saturation * limit
            gap = before - wish
            pressure = wish + self._gg * gap + self._gf * rate_before
            rate = self._fg * gap + self._ff * rate_before
        self.pressure = pressure
        self.rate = rate
        return setpoint
