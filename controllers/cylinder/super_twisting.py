"""Super-twisting sliding mode with the regulators' lead."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit

from controllers.cylinder.differential import DifferentialRange, RegulatorLead
from controllers.cylinder.law import Integral, Output, PairLaw
from controllers.cylinder.types import PairModel
from controllers.estimators import ForceObserver, disturbance_gains


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


class SuperTwisting(PairLaw[SuperTwistingSettings]):
    """Second-order sliding mode on ``s = v_ref - v + lambda (x_ref - x)``.

    References
    ----------
    A. Levant, "Sliding order and sliding accuracy in sliding mode control", Int. J. Control 58(6),
    1993.
    """

    Settings = SuperTwistingSettings

    def __init__(self, settings: SuperTwistingSettings, model: PairModel, period: float) -> None:
        super().__init__(settings, model, period)
        self._mass = model.mass
        self._viscous = model.viscous
        self._range = DifferentialRange(model, settings.pressure_floor)
        self._lead = RegulatorLead(model, settings.lead_bandwidth, self._range.limit, period)
        gains = disturbance_gains(
            period, settings.resolution, model.mass, settings.force_noise, settings.observed_rate
        )
        self._observer = ForceObserver(gains, model.mass, period)
        rate = settings.disturbance_rate
        self._root_gain = settings.proportional_factor * math.sqrt(rate * model.mass)
        self._integral = Integral()
        self._integral_step = settings.integral_factor * rate * period
        self._root_boundary = 1.0 / math.sqrt(settings.boundary)
        self._per_boundary = 1.0 / settings.boundary

    def _begin(self, position: float, difference: float) -> None:
        differential = self._range.clip(difference)
        self._observer.reset(position, self._area * difference)
        self._lead.reset(differential)
        self._integral.reset(self._area * differential)

    def _step(
        self,
        measured: float,
        difference: float,
        wanted: float,
        wanted_velocity: float,
        wanted_acceleration: float,
        load: float,
    ) -> Output:
        settings, lead, observer, integral = (
            self.settings,
            self._lead,
            self._observer,
            self._integral,
        )
        observer.update(measured, self._area * difference)
        position, velocity = observer.predict(self.period)
        slip = wanted_velocity - velocity
        surface = slip + settings.surface_rate * (wanted - position)
        if abs(surface) < settings.boundary:
            root = surface * self._root_boundary
            sign = surface * self._per_boundary
        else:
            sign = math.copysign(1.0, surface)
            root = sign * math.sqrt(abs(surface))
        wish = integral.wish(
            self._mass * (wanted_acceleration + settings.surface_rate * slip)
            + self._viscous * wanted_velocity
            + self._root_gain * root
            + load
        )
        setpoint = lead.update(self._per_area * wish)
        integral.grow(self._integral_step, sign, lead.saturation)
        return (
            *self._range.share(setpoint),
            velocity,
            observer.disturbance,
            wish - load - self._viscous * wanted_velocity,
        )
