"""The cascade's law as numbers: one source for Python and for the loop, where it is compiled."""

import math

from controllers.compiled import inlined
from controllers.cylinder.cascade_settings import CascadeSettings
from controllers.cylinder.differential import DifferentialRange, RegulatorLead
from controllers.cylinder.feedforward import Feedforward
from controllers.cylinder.law import Integral, Output
from controllers.cylinder.numeric_law import PairNumbers
from controllers.cylinder.types import PairModel
from controllers.estimators import ForceObserver, StandstillDetector, observer_gains

_REST_SPEED, _REST_TIME = 5e-5, 0.1
"""A reference rests if it is slower than this (m/s) and stays so for this time (s): a sine that
turns round does not."""
_STILL_DISTANCE, _STILL_TIME = 5e-6, 0.04
"""A pair that moves less than this (m) in this time (s) sticks. On its bristles it may creep."""

_CREEP_SPEED = 3e-3
"""Slower than this (m/s) a pair may stick short of its reference; one that still slides towards
it needs no push, and would overshoot with one."""

_DAMPED, _DAMPED_LEAST, _DAMPED_MOST = 0.25, 0.5, 2.0
"""The velocity gain grows with this power of the viscous friction over that of the tuning. The
ratio is kept between these two: beyond them it has not been tried."""

# What the law calls of its parts. They take a record for their `self` as they take an object.
_sticks = inlined(StandstillDetector.update)
_observe = inlined(ForceObserver.update)
_predict = inlined(ForceObserver.predict)
_feed_forward = inlined(Feedforward.update)
_learn = inlined(Feedforward.learn)
_lead = inlined(RegulatorLead.update)
_wish = inlined(Integral.wish)
_grow = inlined(Integral.grow)
_share = inlined(DifferentialRange.share)


class CascadeLaw(PairNumbers):
    """The numbers of a `Cascade`: its gains, what it remembers, and its step of one period.

    Parameters
    ----------
    settings : CascadeSettings
        Bandwidths and gains.
    model : PairModel
        Pressures, area, mass, friction, regulators.
    period : float
        The loop's period, s.
    """

    def __init__(self, settings: CascadeSettings, model: PairModel, period: float) -> None:
        self._position_rate = settings.position_rate
        tuned = settings.tuned_viscous
        share = 1.0 if tuned is None else model.viscous / tuned
        damped = min(max(share, _DAMPED_LEAST), _DAMPED_MOST) ** _DAMPED
        self._velocity_gain = model.mass * settings.velocity_rate * damped
        self._force_trust = settings.force_trust
        self._disturbance_gain = settings.disturbance_gain
        self._disturbance_share = 1.0 - math.exp(-settings.disturbance_bandwidth * period)
        self._moving_step = settings.integral * period
        self._holding_step = settings.hold_integral * period
        self._trim_step = settings.trim_rate * period
        self._trim_limit = settings.trim_limit
        self._preview = settings.anticipation * model.air_dead_time
        self._delay = self._preview + (period if settings.delay is None else settings.delay)
        self._area = model.area
        self._per_area = 1.0 / model.area
        self._range = DifferentialRange(model, settings.pressure_floor, settings.differential_limit)
        self._lead = RegulatorLead(model, settings.lead_bandwidth, self._range.limit, period)
        self._feedforward = Feedforward(settings.feedforward, model, period)
        gains = observer_gains(settings.observer_bandwidth, model.mass, period)
        self._observer = ForceObserver(gains, model.mass, period)
        self._standstill = StandstillDetector(_STILL_DISTANCE, _STILL_TIME, period)
        self._integral = Integral()
        self._residual = 0.0
        self._trim = 0.0

    def reset(self, position: float, difference: float) -> None:
        """Start bumplessly; see `PairNumbers.reset`."""
        differential = self._range.clip(difference)
        self._standstill.reset(position)
        self._observer.reset(position, self._force_trust * self._area * difference)
        self._lead.reset(differential)
        self._feedforward.reset()
        self._integral.reset(self._area * differential)
        self._residual = self._trim = 0.0

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
        # What is asked for now acts after the dead time: it is worked out for that instant.
        ahead = self._preview
        wanted += ahead * (wanted_velocity + 0.5 * ahead * wanted_acceleration)
        wanted_velocity += ahead * wanted_acceleration
        lead, observer, feedforward = self._lead, self._observer, self._feedforward
        integral = self._integral
        force = self._area * difference
        trusted = self._force_trust * force
        sticks = _sticks(self._standstill, measured)
        _observe(observer, measured, trusted)
        position, velocity = _predict(observer, self._delay)
        error = wanted - position
        disturbance = observer.disturbance + trusted - force
        rests = abs(wanted_velocity) + _REST_TIME * abs(wanted_acceleration) < _REST_SPEED
        creeps = -_CREEP_SPEED < velocity < _CREEP_SPEED
        known = load + _feed_forward(
            feedforward, wanted_velocity, wanted_acceleration, error if creeps else 0.0
        )
        direct = known + self._velocity_gain * (
            wanted_velocity - velocity + self._position_rate * error
        )
        if self._disturbance_gain > 0.0:
            # What the feedforward and the integral do not explain of the observed disturbance.
            missing = -disturbance - known - integral.value
            self._residual += self._disturbance_share * (missing - self._residual)
            direct += self._disturbance_gain * self._residual
        wish = _wish(integral, direct)
        trim = self._trim
        setpoint = _lead(lead, self._per_area * wish) + trim
        step = self._holding_step if sticks and rests else self._moving_step
        _grow(integral, step, error, lead.saturation)
        integral.value -= _learn(feedforward, integral.value)
        # What the regulators are off, seen by their own monitors, needs no position error.
        trim += self._trim_step * (lead.pressure - difference)
        most = self._trim_limit
        self._trim = -most if trim < -most else most if trim > most else trim
        first, second = _share(self._range, setpoint)
        return first, second, velocity, disturbance, wish - known


inlined(CascadeLaw.step)
