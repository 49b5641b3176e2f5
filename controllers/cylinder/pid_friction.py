"""PID with what a patient user adds to it: friction feedforward, lead and dither."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit

from controllers.base import Tunable
from controllers.compiled import inlined
from controllers.cylinder.differential import DifferentialRange, RegulatorLead
from controllers.cylinder.feedforward import Feedforward, FeedforwardSettings
from controllers.cylinder.law import Integral, Output
from controllers.cylinder.numeric_law import NumericPairLaw, PairNumbers
from controllers.cylinder.types import PairModel
from controllers.estimators import MotionEstimator, motion_gains

_estimate = inlined(MotionEstimator.update)
_predict = inlined(MotionEstimator.predict)
_feed_forward = inlined(Feedforward.update)
_learn = inlined(Feedforward.learn)
_lead = inlined(RegulatorLead.update)
_wish = inlined(Integral.wish)
_grow = inlined(Integral.grow)
_share = inlined(DifferentialRange.share)


@dataclass(frozen=True, slots=True)
class PidFrictionSettings:
    """Gains from position to differential pressure, feedforward, lead and dither.

    The defaults are tuned for standard seals at 1 kHz.

    Parameters
    ----------
    proportional : float
        Differential pressure for each metre of error, Pa/m.
    integral : float
        The same for what the error adds up to, Pa/(m s).
    derivative : float
        The same for how fast the error changes, Pa s/m.
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


class PidFrictionLaw(PairNumbers):
    """The numbers of a `PidFriction`, and its step of one period.

    Parameters
    ----------
    settings : PidFrictionSettings
        Gains.
    model : PairModel
        Pressures, area, mass, friction, regulators.
    period : float
        The loop's period, s.
    """

    def __init__(self, settings: PidFrictionSettings, model: PairModel, period: float) -> None:
        self._area = model.area
        self._per_area = 1.0 / model.area
        self._period = period
        self._proportional = settings.proportional
        self._derivative = settings.derivative
        self._integral_step = settings.integral * period
        self._range = DifferentialRange(model, settings.pressure_floor)
        self._lead = RegulatorLead(model, settings.lead_bandwidth, self._range.limit, period)
        self._feedforward = Feedforward(settings.feedforward, model, period)
        gains = motion_gains(period, settings.resolution, settings.acceleration_step)
        self._motion = MotionEstimator(gains, period)
        self._integral = Integral()
        self._dither_amplitude = settings.dither_amplitude
        self._dither_step = 2.0 * math.pi * settings.dither_frequency * period
        self._dither_phase = 0.0

    def reset(self, position: float, difference: float) -> None:
        """Start bumplessly; see `PairNumbers.reset`."""
        differential = self._range.clip(difference)
        self._integral.reset(differential)
        self._lead.reset(differential)
        self._feedforward.reset()
        self._motion.reset(position)
        self._dither_phase = 0.0

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
        lead, integral, friction = self._lead, self._integral, self._feedforward
        _estimate(self._motion, measured)
        position, velocity = _predict(self._motion, self._period)
        error = wanted - position
        feedforward = self._per_area * (
            _feed_forward(friction, wanted_velocity, wanted_acceleration, error) + load
        )
        wish = _wish(
            integral,
            self._proportional * error
            + self._derivative * (wanted_velocity - velocity)
            + feedforward,
        )
        setpoint = _lead(lead, wish)
        _grow(integral, self._integral_step, error, lead.saturation)
        integral.value -= self._per_area * _learn(friction, self._area * integral.value)
        if self._dither_amplitude > 0.0:
            setpoint += self._dither_amplitude * math.sin(self._dither_phase)
            self._dither_phase = (self._dither_phase + self._dither_step) % math.tau
        first, second = _share(self._range, setpoint)
        return (
            first,
            second,
            velocity,
            -self._area * integral.value,
            self._area * (wish - feedforward),
        )


inlined(PidFrictionLaw.step)


class PidFriction(NumericPairLaw[PidFrictionSettings]):
    """PID on an estimated velocity, with friction feedforward, regulator lead and dither."""

    Settings = PidFrictionSettings
    Numbers = PidFrictionLaw
    tunables = (
        Tunable("proportional", 1e5, 5e8),
        Tunable("integral", 1e5, 5e9),
        Tunable("derivative", 1e3, 5e6),
        Tunable("lead_bandwidth", 60.0, 600.0),
        Tunable("acceleration_step", 1e-2, 1e1),
        Tunable("feedforward.gain", 0.3, 1.3),
        Tunable("feedforward.rounding", 1e-4, 1e-2),
        Tunable("feedforward.error_rate", 0.05, 50.0),
    )
    online = (
        Tunable("proportional", 1e5, 5e8),
        Tunable("integral", 0.0, 5e9),
        Tunable("derivative", 0.0, 5e6),
        Tunable("dither_amplitude", 0.0, 20e3),
        Tunable("feedforward.gain", 0.0, 1.3),
    )
