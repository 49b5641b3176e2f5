"""The cascade of a pair as it is usually written: a filterpy filter, numpy around it.

It is the law of `controllers.cylinder.cascade`, part for part: a mass that the measured force
drives with its disturbance as third state, prediction over the delay, friction with memory whose
size is learnt, two loops, integral, disturbance compensation, the lead as a state-space model,
and the trim of the regulators. Only the observer's gains come from a running Kalman filter, as
filterpy has it, instead of from a bandwidth; the filter's noise is chosen for a similar one.
"""

import numpy as np
from filterpy.kalman import KalmanFilter

REST_SPEED, REST_TIME = 5e-5, 0.1
STILL_DISTANCE, STILL_TIME = 5e-6, 0.04
CREEP_SPEED, LEAST_SPEED, NEAR = 3e-3, 0.5e-3, 0.5e-3
READING_NOISE = 1e-4  # m
SHARE = 0.7  # of the observer's bandwidth: with it the setpoints are nearest to ours


class StockCascade:
    """Position over velocity over force.

    Parameters
    ----------
    settings : CascadeSettings
        The profile's.
    model : PairModel
        Area, mass, friction, regulators.
    period : float
        s.
    """

    def __init__(self, settings, model, period):
        self.model, self.period = model, period
        self.settings = settings
        self.friction = settings.feedforward
        self.kalman = _force_filter(settings.observer_bandwidth, model.mass, period)
        self.preview = settings.anticipation * model.air_dead_time
        self.ahead, self.push = _motion(model.mass, period + self.preview)
        self.force = self.integral = self.residual = self.trim = 0.0
        self.share, self.scale = 0.0, 1.0
        self.disturbance_share = 1.0 - np.exp(-settings.disturbance_bandwidth * period)
        self.limit = 2.0 * min(
            model.base_pressure - settings.pressure_floor,
            model.pressure_max - model.base_pressure,
        )
        # The lead: a critically damped low-pass [f, f'], and the setpoint that makes regulators
        # put out f. The setpoint is an affine function of the wish, with this slope.
        x, decay = settings.lead_bandwidth * period, np.exp(-settings.lead_bandwidth * period)
        self.lead = np.zeros(2)
        self.lead_step = decay * np.array(
            [[1.0 + x, period], [-settings.lead_bandwidth * x, 1.0 - x]]
        )
        self.lead_input = np.array([1.0, 0.0]) - self.lead_step[:, 0]
        bandwidth, damping = model.regulator_bandwidth, model.regulator_damping
        self.lead_level = np.array([0.5, damping / bandwidth])
        self.lead_change = np.array([0.0, 1.0 / (bandwidth**2 * period)])
        self.lead_slope = (self.lead_level + self.lead_change) @ self.lead_input
        self.split = 0.5 * np.array([1.0, -1.0])
        self.anchor, self.still = 0.0, 0
        self.still_cycles = round(STILL_TIME / period)
        self.started = False
        self.estimate = np.zeros(2)

    def reset(self, position, pressure):
        """Start bumplessly at a position (m) and pressures (Pa)."""
        difference = pressure[0] - pressure[1]
        self.force = self.settings.force_trust * self.model.area * difference
        self.kalman.x = np.array([[position], [0.0], [-self.force]])
        self.lead = np.array([difference, 0.0])
        self.integral = self.model.area * difference
        self.anchor = position

    def update(self, position, pressure, reference):
        """Return the setpoints, Pa, for a position (m), pressures (Pa) and a reference."""
        settings, model, period = self.settings, self.model, self.period
        early = self.preview
        reference = reference + early * np.array(
            [reference[1] + 0.5 * early * reference[2], reference[2], 0.0]
        )
        difference = pressure[0] - pressure[1]
        force = model.area * difference
        trusted = settings.force_trust * force
        sticks = self.stands_still(position)
        kalman = self.kalman
        kalman.predict(u=0.5 * (self.force + trusted))
        kalman.update(position)
        self.force = trusted
        ahead = (self.ahead @ kalman.x + self.push * trusted)[:, 0]
        disturbance = ahead[2] + trusted - force

        error, velocity_error = reference[:2] - ahead[:2]
        rests = abs(reference[1]) + REST_TIME * abs(reference[2]) < REST_SPEED
        friction = self.friction_force(reference[1], error if abs(ahead[1]) < CREEP_SPEED else 0.0)
        feedforward = model.mass * reference[2] + self.scale * friction
        direct = feedforward + model.mass * settings.velocity_rate * (
            velocity_error + settings.position_rate * error
        )
        missing = -disturbance - feedforward - self.integral
        self.residual += self.disturbance_share * (missing - self.residual)
        direct += settings.disturbance_gain * self.residual
        if not self.started:
            self.started = True
            self.integral -= direct
        setpoint, saturation = self.invert((direct + self.integral) / model.area)
        setpoint += self.trim
        if saturation * error <= 0.0:
            rate = settings.hold_integral if sticks and rests else settings.integral
            self.integral += rate * period * error
        self.learn(reference[1], friction)
        trim = self.trim + settings.trim_rate * period * (self.lead[0] - difference)
        self.trim = min(max(trim, -settings.trim_limit), settings.trim_limit)
        self.estimate = np.array([ahead[1], disturbance])
        setpoint = min(max(setpoint, -self.limit), self.limit)
        return model.base_pressure + setpoint * self.split

    def stands_still(self, position):
        """Return whether the pair has stood still for a while."""
        if abs(position - self.anchor) > STILL_DISTANCE:
            self.anchor, self.still = position, 0
            return False
        self.still += 1
        if self.still >= 2 * self.still_cycles:
            self.anchor, self.still = position, self.still_cycles
        return self.still >= self.still_cycles

    def friction_force(self, velocity, error):
        """Return the friction (N) of the desired motion, which turns over a distance."""
        if abs(error) < NEAR:
            velocity = velocity + self.friction.error_rate * error
        moved = velocity * self.period / self.friction.distance
        self.share = (self.share + moved) / (1.0 + abs(moved))
        coulomb = self.friction.gain * self.model.coulomb
        return coulomb * self.share + self.model.viscous * velocity

    def learn(self, velocity, friction):
        """Move what the integral holds against friction into the feedforward."""
        full = self.friction.gain * self.model.coulomb
        if abs(velocity) < LEAST_SPEED or abs(friction) < 0.9 * full:
            return
        gained = self.friction.learning_rate * self.period * self.integral / friction
        scale = min(max(self.scale + gained, 0.25), 3.0)
        self.integral -= (scale - self.scale) * friction
        self.scale = scale

    def invert(self, wish):
        """Return the setpoint for a wished differential (Pa) and the side where it saturates."""
        after = self.lead_step @ self.lead + self.lead_input * wish
        setpoint = self.lead_level @ (self.lead + after) + self.lead_change @ (after - self.lead)
        saturation = 0
        if abs(setpoint) > self.limit:
            saturation = np.sign(setpoint)
            wish += (saturation * self.limit - setpoint) / self.lead_slope
            setpoint = saturation * self.limit
            after = self.lead_step @ self.lead + self.lead_input * wish
        self.lead = after
        return setpoint, saturation


def _motion(mass, time):
    """Return how position, velocity and disturbance, and what a force adds, are after a time."""
    push = np.array([[0.5 * time**2 / mass], [time / mass], [0.0]])
    return np.array([[1.0, time, push[0, 0]], [0.0, 1.0, push[1, 0]], [0.0, 0.0, 1.0]]), push


def _force_filter(bandwidth, mass, period):
    """Return a Kalman filter of position, velocity and disturbance that a force drives."""
    kalman = KalmanFilter(dim_x=3, dim_z=1, dim_u=1)
    kalman.F, push = _motion(mass, period)
    kalman.B = push
    kalman.H = np.array([[1.0, 0.0, 0.0]])
    kalman.R *= READING_NOISE**2
    kalman.Q = push @ push.T * 0.1**2
    # In steady state its poles lie on a circle of this bandwidth, as a Butterworth filter's.
    kalman.Q[2, 2] = (READING_NOISE * mass * (SHARE * bandwidth) ** 3 * period) ** 2
    return kalman
