"""Super-twisting sliding mode with the regulators' lead."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit

from controllers.cylinder.differential import DifferentialRange, RegulatorLead
from controllers.cylinder.types import (
    PairCommand,
    PairEstimate,
    PairModel,
    PairReference,
    PairState,
)
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


class SuperTwisting:
    """Second-order sliding mode on ``s = v_ref - v + lambda (x_ref - x)``.

    Parameters
    ----------
    settings : SuperTwistingSettings
        Surface and gains.
    model : PairModel
        Pressures, area, mass, regulators.
    period : float
        The loop's period, s.

    References
    ----------
    A. Levant, "Sliding order and sliding accuracy in sliding mode control", Int. J. Control 58(6),
    1993.
    """

    Settings = SuperTwistingSettings

    def __init__(self, settings: SuperTwistingSettings, model: PairModel, period: float) -> None:
        self._settings = settings
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
        self._root_gain = settings.proportional_factor * math.sqrt(rate * model.mass)
        self._integral_step = settings.integral_factor * rate * period
        self._root_boundary = 1.0 / math.sqrt(settings.boundary)
        self._per_boundary = 1.0 / settings.boundary
        self._integral = 0.0
        self._started = False
        self.estimate = PairEstimate(0.0, 0.0)
        """Velocity at the time of use, and the disturbance of the estimator."""
        self.correction = 0.0
        """Force of the last update that came from errors and not from the reference, N."""

    def compile(self) -> None:
        """Do nothing: there is nothing to compile."""

    def reset(self, state: PairState) -> None:
        """Start bumplessly: the first command is the measured differential."""
        differential = self._range.clip(state.agonist - state.antagonist)
        force = self._area * (state.agonist - state.antagonist)
        self._observer.reset(state.position, force)
        self._lead.reset(differential)
        self._integral = self._area * differential
        self._started = False
        self.estimate = PairEstimate(0.0, -force)

    def update(self, state: PairState, reference: PairReference, load: float = 0.0) -> PairCommand:
        """Return the setpoints for this period.

        Parameters
        ----------
        state, reference : PairState, PairReference
            What is, and what should be.
        load : float
            Force that the motion is known to take beyond the pair's own, N: what hangs on it.
        """
        settings, lead, observer = self._settings, self._lead, self._observer
        observer.update(state.position, self._area * (state.agonist - state.antagonist))
        position, velocity = observer.predict(self._period)
        slip = reference.velocity - velocity
        surface = slip + settings.surface_rate * (reference.position - position)
        if abs(surface) < settings.boundary:
            root = surface * self._root_boundary
            sign = surface * self._per_boundary
        else:
            sign = math.copysign(1.0, surface)
            root = sign * math.sqrt(abs(surface))
        direct = (
            self._mass * (reference.acceleration + settings.surface_rate * slip)
            + self._viscous * reference.velocity
            + self._root_gain * root
            + load
        )
        if not self._started:
            self._started = True
            self._integral -= direct
        wish = direct + self._integral
        self.correction = wish - load - self._viscous * reference.velocity
        setpoint = lead.update(self._per_area * wish)
        if lead.saturation * sign <= 0.0:
            self._integral += self._integral_step * sign
        self.estimate = PairEstimate(velocity, observer.disturbance)
        return self._range.split(setpoint)
