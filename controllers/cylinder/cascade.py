"""Cascade of position and velocity loops on an observer that is fed with measured pressures."""

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
from controllers.estimators import ForceObserver, StandstillDetector, observer_gains

_new = tuple.__new__  # makes a named tuple in half the time that its class takes

_REST_SPEED, _REST_TIME = 5e-5, 0.1
"""A reference rests if it is slower than this (m/s) and stays so for this time (s): a sine that
turns round does not."""
_STILL_DISTANCE, _STILL_TIME = 5e-6, 0.04
"""A pair that moves less than this (m) in this time (s) sticks. On its bristles it may creep."""

_CREEP_SPEED = 3e-3
"""Slower than this (m/s) a pair may stick short of its reference; one that still slides towards
it needs no push, and would overshoot with one."""


@dataclass(frozen=True, slots=True)
class CascadeSettings:
    """Bandwidths of the loops, of the observer and of the lead.

    The defaults are tuned for standard seals at 1 kHz; low-speed seals take less.

    Parameters
    ----------
    position_rate : float
        Velocity asked for over the position error, rad/s.
    velocity_rate : float
        Acceleration asked for over the velocity error, rad/s.
    integral : float
        N/(m s), while the reference moves.
    hold_integral : float
        N/(m s), while it rests and the pair sticks. It then is a spring of some 4e5 N/m (the
        bristles of its contacts), on which the integral that suits sliding would take ten
        seconds; on a pair that slides this one would oscillate.
    observer_bandwidth : float
        rad/s; it follows the encoder: 800 to 1200 for 1 µm, two to three times less for 5 to
        10 µm.
    force_trust : float
        Share of the measured force that drives the observer's mass. With 1 a fast change of the
        force in a pair that still sticks is taken for motion until the disturbance has followed,
        ``3 F' / (M w²)``, and the monitors' noise gets into the velocity; with 0 the velocity
        comes from the encoders alone. The disturbance counts the whole force either way.
    lead_bandwidth : float
        Of the low-pass behind which the regulators' dynamics are inverted, rad/s.
    disturbance_gain : float
        Share of what the observer sees beyond the feedforward that is compensated at once; 0
        leaves it to the integral.
    disturbance_bandwidth : float
        Of that compensation, rad/s.
    trim_rate : float
        How fast the regulators' static error is trimmed by their monitors, rad/s.
    trim_limit : float
        Greatest differential that the trim adds, Pa: no more than two regulators may be off by
        linearity and hysteresis, because a pressure that does not follow is not to be chased.
    delay : float, optional
        From the readings to the moment that they are used for, s: the state is predicted over
        it. None: one period, as on a bus that is read at the end of a cycle.
    pressure_floor : float
        No setpoint goes below, Pa gauge, so that no wire goes slack.
    differential_limit : float, optional
        Greatest differential setpoint, Pa: head-room of the lead. Beyond what the floor leaves
        around the base pressure one chamber goes on alone, and the mean rises for moments. None:
        the mean stays.
    feedforward : FeedforwardSettings
        Inertia and friction of the desired motion.
    """

    position_rate: Annotated[float, Unit("rad/s"), Ge(0)] = 120.0
    velocity_rate: Annotated[float, Unit("rad/s"), Ge(0)] = 700.0
    integral: Annotated[float, Unit("N/(m s)"), Ge(0)] = 8.0e4
    hold_integral: Annotated[float, Unit("N/(m s)"), Ge(0)] = 4.5e5
    observer_bandwidth: Annotated[float, Unit("rad/s"), Gt(0), Le(5000)] = 1200.0
    force_trust: Annotated[float, Ge(0), Le(1)] = 0.2
    lead_bandwidth: Annotated[float, Unit("rad/s"), Gt(0), Le(3000)] = 600.0
    disturbance_gain: Annotated[float, Ge(0), Le(1)] = 0.1
    disturbance_bandwidth: Annotated[float, Unit("rad/s"), Gt(0)] = 40.0
    trim_rate: Annotated[float, Unit("rad/s"), Ge(0), Le(30)] = 3.0
    trim_limit: Annotated[float, Unit("Pa"), Ge(0)] = 15e3
    delay: Annotated[float, Unit("s"), Ge(0)] | None = None
    pressure_floor: Annotated[float, Unit("Pa"), Ge(0)] = 20e3
    differential_limit: Annotated[float, Unit("Pa"), Gt(0)] | None = None
    feedforward: FeedforwardSettings = field(
        default_factory=lambda: FeedforwardSettings(error_rate=2.0)
    )


class Cascade:
    """Position over velocity over force, with an observer, feedforward, integral and lead.

    Parameters
    ----------
    settings : CascadeSettings
        Bandwidths and gains.
    model : PairModel
        Pressures, area, mass, friction, regulators.
    period : float
        The loop's period, s.

    Notes
    -----
    Taking its parts away one by one on the simulated pair shows that lead, integral, friction
    feedforward and a fast observer fed with the measured force carry it.
    """

    Settings = CascadeSettings

    def __init__(self, settings: CascadeSettings, model: PairModel, period: float) -> None:
        self._settings = settings
        self._position_rate = settings.position_rate
        self._force_trust = settings.force_trust
        self._disturbance_gain = settings.disturbance_gain
        self._trim_limit = settings.trim_limit
        self._area = model.area
        self._per_area = 1.0 / model.area
        self._range = DifferentialRange(model, settings.pressure_floor, settings.differential_limit)
        self._lead = RegulatorLead(model, settings.lead_bandwidth, self._range.limit, period)
        self._feedforward = Feedforward(settings.feedforward, model, period)
        gains = observer_gains(settings.observer_bandwidth, model.mass, period)
        self._observer = ForceObserver(gains, model.mass, period)
        self._standstill = StandstillDetector(_STILL_DISTANCE, _STILL_TIME, period)
        self._velocity_gain = model.mass * settings.velocity_rate
        self._moving_step = settings.integral * period
        self._holding_step = settings.hold_integral * period
        self._disturbance_share = 1.0 - math.exp(-settings.disturbance_bandwidth * period)
        self._trim_step = settings.trim_rate * period
        self._delay = period if settings.delay is None else settings.delay
        self._integral = 0.0
        self._residual = 0.0
        self._trim = 0.0
        self._started = False
        self.estimate = PairEstimate(0.0, 0.0)
        """Velocity at the time of use, and the disturbance of the observer."""
        self.correction = 0.0
        """Force of the last update that came from errors and not from the reference, N."""

    def reset(self, state: PairState) -> None:
        """Start bumplessly: the first command is the measured differential."""
        differential = self._range.clip(state.agonist - state.antagonist)
        force = self._area * (state.agonist - state.antagonist)
        self._standstill.reset(state.position)
        self._observer.reset(state.position, self._force_trust * force)
        self._lead.reset(differential)
        self._feedforward.reset()
        self._integral = self._area * differential
        self._residual = 0.0
        self._trim = 0.0
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
        lead, observer = self._lead, self._observer
        _, measured, agonist, antagonist = state
        wanted, wanted_velocity, wanted_acceleration = reference
        difference = agonist - antagonist
        force = self._area * difference
        trusted = self._force_trust * force
        sticks = self._standstill.update(measured)
        observer.update(measured, trusted)
        position, velocity = observer.predict(self._delay)
        error = wanted - position
        disturbance = observer.disturbance + trusted - force
        rests = abs(wanted_velocity) + _REST_TIME * abs(wanted_acceleration) < _REST_SPEED
        feedforward = self._feedforward.update(
            reference, error if -_CREEP_SPEED < velocity < _CREEP_SPEED else 0.0
        )
        feedforward += load
        direct = feedforward + self._velocity_gain * (
            wanted_velocity - velocity + self._position_rate * error
        )
        integral = self._integral
        if self._disturbance_gain > 0.0:
            # What the feedforward and the integral do not explain of the observed disturbance.
            missing = -disturbance - feedforward - integral
            self._residual += self._disturbance_share * (missing - self._residual)
            direct += self._disturbance_gain * self._residual
        if not self._started:
            self._started = True
            integral -= direct
        wish = direct + integral
        self.correction = wish - feedforward
        trim = self._trim
        setpoint = lead.update(self._per_area * wish) + trim
        if lead.saturation * error <= 0.0:
            integral += (self._holding_step if sticks and rests else self._moving_step) * error
        self._integral = integral - self._feedforward.learn(integral)
        # What the regulators are off, seen by their own monitors, needs no position error.
        trim += self._trim_step * (lead.pressure - difference)
        most = self._trim_limit
        self._trim = -most if trim < -most else most if trim > most else trim
        self.estimate = _new(PairEstimate, (velocity, disturbance))
        return self._range.split(setpoint)
