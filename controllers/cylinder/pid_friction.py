"""PID with what a patient user adds to it: friction feedforward, lead and dither."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit

from controllers.cylinder.differential import DifferentialRange, RegulatorLead
from controllers.cylinder.feedforward import Feedforward, FeedforwardSettings
from controllers.cylinder.types import (
    PairCommand,
    PairEstimate,
    PairModel,
    PairReference,
    PairState,
)
from controllers.estimators import MotionEstimator, motion_gains


@dataclass(frozen=True, slots=True)
class PidFrictionSettings:
    """Gains from position to differential pressure, feedforward, lead and dither.

    The defaults are tuned for standard seals at 1 kHz.

    Parameters
    ----------
    proportional : float
        Pa/m.
    integral : float
        Pa/(m s).
    derivative : float
        Pa s/m.
    lead_bandwidth : float
        Of the low-pass behind which the regulators' dynamics are inverted, rad/s.
    dither_amplitude : float
        Of the differential setpoint, Pa; in simulation 1.5 to 13 kPa help standard
        seals at low speed, and shake the pair once it slides.
    dither_frequency : float
        Hz; 19 to 25 there.
    resolution : float
        Of the encoder, m.
    acceleration_step : float
        How much the acceleration may change in a period, m/s²: more makes the velocity quicker
        and noisier (0.17 suits smooth motion, 1.7 stick-slip).
    pressure_floor : float
        No setpoint goes below, Pa gauge, so that no wire goes slack.
    feedforward : FeedforwardSettings
        Inertia and friction of the desired motion.
    """

    proportional: Annotated[float, Unit("Pa/m"), Ge(0)] = 5.1e7
    integral: Annotated[float, Unit("Pa/(m s)"), Ge(0)] = 5.0e8
    derivative: Annotated[float, Unit("Pa s/m"), Ge(0)] = 3.0e5
    lead_bandwidth: Annotated[float, Unit("rad/s"), Gt(0), Le(3000)] = 350.0
    dither_amplitude: Annotated[float, Unit("Pa"), Ge(0)] = 800.0
    dither_frequency: Annotated[float, Unit("Hz"), Gt(0)] = 17.0
    resolution: Annotated[float, Unit("m"), Gt(0)] = 1e-6
    acceleration_step: Annotated[float, Unit("m/s^2"), Gt(0)] = 0.85
    pressure_floor: Annotated[float, Unit("Pa"), Ge(0)] = 20e3
    feedforward: FeedforwardSettings = field(
        default_factory=lambda: FeedforwardSettings(
            friction="smooth", rounding=5e-4, learning_rate=0.0, error_rate=1.3
        )
    )


class PidFriction:
    """PID on an estimated velocity, with friction feedforward, regulator lead and dither.

    Parameters
    ----------
    settings : PidFrictionSettings
        Gains.
    model : PairModel
        Pressures, area, friction, regulators.
    period : float
        The loop's period, s.
    """

    Settings = PidFrictionSettings

    def __init__(self, settings: PidFrictionSettings, model: PairModel, period: float) -> None:
        self._settings = settings
        self._area = model.area
        self._per_area = 1.0 / model.area
        self._period = period
        self._range = DifferentialRange(model, settings.pressure_floor)
        self._lead = RegulatorLead(model, settings.lead_bandwidth, self._range.limit, period)
        self._feedforward = Feedforward(settings.feedforward, model, period)
        gains = motion_gains(period, settings.resolution, settings.acceleration_step)
        self._motion = MotionEstimator(gains, period)
        self._integral_step = settings.integral * period
        self._dither_step = 2.0 * math.pi * settings.dither_frequency * period
        self._dither_phase = 0.0
        self._integral = 0.0
        self._started = False
        self.estimate = PairEstimate(0.0, 0.0)
        """Velocity, and the force that the integral holds against."""
        self.correction = 0.0
        """Force of the last update that came from errors and not from the reference, N."""

    def compile(self) -> None:
        """Do nothing: there is nothing to compile."""

    def reset(self, state: PairState) -> None:
        """Start bumplessly: the first command is the measured differential."""
        self._integral = self._range.clip(state.agonist - state.antagonist)
        self._lead.reset(self._integral)
        self._feedforward.reset()
        self._motion.reset(state.position)
        self._dither_phase = 0.0
        self._started = False
        self.estimate = PairEstimate(0.0, -self._area * self._integral)

    def update(self, state: PairState, reference: PairReference, load: float = 0.0) -> PairCommand:
        """Return the setpoints for this period.

        Parameters
        ----------
        state, reference : PairState, PairReference
            What is, and what should be.
        load : float
            Force that the motion is known to take beyond the pair's own, N: what hangs on it.
        """
        settings, lead = self._settings, self._lead
        self._motion.update(state.position)
        position, velocity = self._motion.predict(self._period)
        error = reference.position - position
        feedforward = self._per_area * (
            self._feedforward.update(reference.velocity, reference.acceleration, error) + load
        )
        direct = (
            settings.proportional * error
            + settings.derivative * (reference.velocity - velocity)
            + feedforward
        )
        if not self._started:
            self._started = True
            self._integral -= direct
        wish = direct + self._integral
        self.correction = self._area * (wish - feedforward)
        setpoint = lead.update(wish)
        if lead.saturation * error <= 0.0:
            self._integral += self._integral_step * error
        self._integral -= self._per_area * self._feedforward.learn(self._area * self._integral)
        if settings.dither_amplitude > 0.0:
            setpoint += settings.dither_amplitude * math.sin(self._dither_phase)
            self._dither_phase = (self._dither_phase + self._dither_step) % math.tau
        self.estimate = PairEstimate(velocity, -self._area * self._integral)
        return self._range.split(setpoint)
