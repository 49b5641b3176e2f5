"""Super-twisting sliding mode with the regulators' lead."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit

from controllers.base import Tunable
from controllers.compiled import inlined
from controllers.cylinder.differential import DifferentialRange, RegulatorLead
from controllers.cylinder.law import Integral, Output
from controllers.cylinder.numeric_law import NumericPairLaw, PairNumbers
from controllers.cylinder.types import PairModel
from controllers.estimators import ForceObserver, disturbance_gains

_observe = inlined(ForceObserver.update)
_predict = inlined(ForceObserver.predict)
_lead = inlined(RegulatorLead.update)
_wish = inlined(Integral.wish)
_grow = inlined(Integral.grow)
_share = inlined(DifferentialRange.share)


@dataclass(frozen=True, slots=True)
class SuperTwistingSettings:
    """The sliding surface, the gains on it and the estimator.

    The defaults are tuned for standard seals at 1 kHz.

    Parameters
    ----------
    surface_rate : float
        Rate at which the position error decays on the surface, rad/s.
    disturbance_rate : float
        L, the fastest disturbance that is met exactly, N/s; both gains follow from it.
    proportional_factor, integral_factor : float
        Of the square-root term over ``sqrt(L / M)`` and of the integral over ``L / M``; Levant
        gives 1.5 and 1.1.
    boundary : float
        Half width of the layer in which the sign is replaced by a slope, m/s: without it the
        regulators' lag makes the pair chatter.
    lead_bandwidth : float
        Of the low-pass behind which the regulators' dynamics are inverted, rad/s.
    resolution : float
        Of the encoder, m.
    force_noise : float
        Noise of the force that the pressure monitors say, rms, N. They say 0.064; more lets the
        encoder count for more, which suits a pair that sticks.
    observed_rate : float
        How fast the estimator lets the disturbance wander, N in a second's square root
        (about 30 fits the friction best; a quiet estimate suits the lead better).
    pressure_floor : float
        No setpoint goes below, Pa gauge, so that no wire goes slack.
    """

    surface_rate: Annotated[float, Unit("rad/s"), Ge(0)] = 50.0
    disturbance_rate: Annotated[float, Unit("N/s"), Gt(0)] = 3600.0
    proportional_factor: Annotated[float, Ge(0), Le(10)] = 0.5
    integral_factor: Annotated[float, Ge(0), Le(10)] = 0.13
    boundary: Annotated[float, Unit("m/s"), Gt(0)] = 4e-3
    lead_bandwidth: Annotated[float, Unit("rad/s"), Gt(0), Le(3000)] = 600.0
    resolution: Annotated[float, Unit("m"), Gt(0)] = 1e-6
    force_noise: Annotated[float, Unit("N"), Gt(0)] = 0.25
    observed_rate: Annotated[float, Gt(0)] = 1.0
    pressure_floor: Annotated[float, Unit("Pa"), Ge(0)] = 20e3


class SuperTwistingLaw(PairNumbers):
    """The numbers of a `SuperTwisting`, and its step of one period.

    Parameters
    ----------
    settings : SuperTwistingSettings
        The surface and the gains on it.
    model : PairModel
        Pressures, area, mass, viscous friction, regulators.
    period : float
        The loop's period, s.
    """

    def __init__(self, settings: SuperTwistingSettings, model: PairModel, period: float) -> None:
        self._area = model.area
        self._per_area = 1.0 / model.area
        self._mass = model.mass
        self._viscous = model.viscous
        self._period = period
        self._range = DifferentialRange(model, settings.pressure_floor)
        self._lead = RegulatorLead(model, settings.lead_bandwidth, self._range.limit, period)
        gains = disturbance_gains(
            period, settings.resolution, model.mass, settings.force_noise, settings.observed_rate
        )
        self._observer = ForceObserver(gains, model.mass, period)
        rate = settings.disturbance_rate
        self._surface_rate = settings.surface_rate
        self._root_gain = settings.proportional_factor * math.sqrt(rate * model.mass)
        self._integral = Integral()
        self._integral_step = settings.integral_factor * rate * period
        self._boundary = settings.boundary
        self._root_boundary = 1.0 / math.sqrt(settings.boundary)
        self._per_boundary = 1.0 / settings.boundary

    def reset(self, position: float, difference: float) -> None:
        """Start bumplessly; see `PairNumbers.reset`."""
        differential = self._range.clip(difference)
        self._observer.reset(position, self._area * difference)
        self._lead.reset(differential)
        self._integral.reset(self._area * differential)

    def step(
        self,
        measured: float,
        difference: float,
        wanted: float,
        wanted_velocity: float,
        wanted_acceleration: float,
        load: float,
    ) -> Output:
        """Advance by one period; see `PairNumbers.step`."""
        lead, observer, integral = self._lead, self._observer, self._integral
        _observe(observer, measured, self._area * difference)
        position, velocity = _predict(observer, self._period)
        slip = wanted_velocity - velocity
        surface = slip + self._surface_rate * (wanted - position)
        if abs(surface) < self._boundary:
            root = surface * self._root_boundary
            sign = surface * self._per_boundary
        else:
            sign = math.copysign(1.0, surface)
            root = sign * math.sqrt(abs(surface))
        wish = _wish(
            integral,
            self._mass * (wanted_acceleration + self._surface_rate * slip)
            + self._viscous * wanted_velocity
            + self._root_gain * root
            + load,
        )
        setpoint = _lead(lead, self._per_area * wish)
        _grow(integral, self._integral_step, sign, lead.saturation)
        first, second = _share(self._range, setpoint)
        return (
            first,
            second,
            velocity,
            observer.disturbance,
            wish - load - self._viscous * wanted_velocity,
        )


inlined(SuperTwistingLaw.step)


class SuperTwisting(NumericPairLaw[SuperTwistingSettings]):
    """Second-order sliding mode on ``s = v_ref - v + lambda (x_ref - x)``.

    References
    ----------
    A. Levant, "Sliding order and sliding accuracy in sliding mode control", Int. J. Control 58(6),
    1993.
    """

    Settings = SuperTwistingSettings
    Numbers = SuperTwistingLaw
    tunables = (
        Tunable("surface_rate", 2.0, 120.0),
        Tunable("disturbance_rate", 10.0, 1e4),
        Tunable("proportional_factor", 0.05, 3.0),
        Tunable("integral_factor", 0.01, 2.0),
        Tunable("boundary", 5e-4, 0.2),
        Tunable("lead_bandwidth", 60.0, 600.0),
        Tunable("force_noise", 0.02, 2.0),
        Tunable("observed_rate", 0.5, 50.0),
    )
    online = (
        Tunable("surface_rate", 0.0, 120.0),
        Tunable("disturbance_rate", 10.0, 1e4),
        Tunable("proportional_factor", 0.0, 3.0),
        Tunable("integral_factor", 0.0, 2.0),
        Tunable("boundary", 5e-4, 0.2),
    )
