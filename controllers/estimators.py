"""Estimators of a position that an encoder measures: velocity, acceleration, disturbance.

They run at their steady gains in plain scalars, about 1 µs a step; a Kalman filter's gains are
designed once, with filterpy, when a controller is built. This is the only module that imports
filterpy, and it does so on use: the import alone takes a second.

Encoders are read once a cycle, at its end, and used at the start of the next: every filter says
what it believes *at the time of the reading* and can predict over the known delay.
"""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from controllers.compiled import PlainNumbers

if TYPE_CHECKING:
    from filterpy.kalman import KalmanFilter

_MOST_STEPS = 5000
"""Of a filter before it has to have settled; the encoders here take some hundred."""


class Gains(NamedTuple):
    """Steady gains on the innovation of a position.

    Parameters
    ----------
    position : float
        1.
    velocity : float
        1/s.
    third : float
        Of the third state: 1/s² for an acceleration, N/m for a disturbance.
    """

    position: float
    velocity: float
    third: float


def fading_memory_gains(bandwidth: float, period: float) -> Gains:
    """Return gains that put all three poles at ``exp(-bandwidth period)``.

    Parameters
    ----------
    bandwidth : float
        rad/s.
    period : float
        s.

    Returns
    -------
    Gains
        `third` belongs to an acceleration, 1/s².

    References
    ----------
    N. Morrison, "Introduction to sequential smoothing and prediction", 1969: the fading-memory
    polynomial filter of second degree, which is the critically damped alpha-beta-gamma filter.
    """
    pole = math.exp(-bandwidth * period)
    gap = 1.0 - pole
    return Gains(1.0 - pole**3, 1.5 * gap * gap * (1.0 + pole) / period, gap**3 / (period * period))


@lru_cache(maxsize=32)
def motion_gains(period: float, resolution: float, acceleration_step: float) -> Gains:
    """Return the steady Kalman gains for position, velocity and acceleration.

    Parameters
    ----------
    period : float
        s.
    resolution : float
        Of the encoder, m; its rounding is white noise of variance ``resolution² / 12``.
    acceleration_step : float
        Standard deviation of the change of the acceleration from one period to the next, m/s².

    Returns
    -------
    Gains
        `third` belongs to the acceleration, 1/s².

    Notes
    -----
    ``Q_discrete_white_noise(3, T, q)``: q of 0.03 (m/s²)² suits smooth motion, 3 suits stick-slip.
    """
    from filterpy.common import Q_discrete_white_noise

    kalman = _constant_gain_filter(period, resolution, (0.5 * period * period, period))
    kalman.Q = Q_discrete_white_noise(3, period, var=acceleration_step**2)
    return Gains(*_settled_gains(kalman))


@lru_cache(maxsize=32)
def disturbance_gains(
    period: float, resolution: float, mass: float, force_noise: float, disturbance_rate: float
) -> Gains:
    """Return the steady Kalman gains for position, velocity and disturbance force.

    Parameters
    ----------
    period : float
        s.
    resolution : float
        Of the encoder, m.
    mass : float
        kg.
    force_noise : float
        Standard deviation of the force that the pressures say, N.
    disturbance_rate : float
        Growth of the disturbance's standard deviation in a second, N/√s: it walks at random.

    Returns
    -------
    Gains
        `third` belongs to the disturbance, N/m.

    Notes
    -----
    The state is ``[x, v, d]`` with the measured force as input, discretised exactly;
    ``disturbance_rate²`` of about 1e3 N²/s suits the pneumatic pair.
    """
    import numpy as np

    push = np.array([[0.5 * period * period / mass], [period / mass], [0.0]])
    kalman = _constant_gain_filter(period, resolution, (push[0, 0], push[1, 0]))
    kalman.Q = push @ push.T * force_noise**2
    kalman.Q[2, 2] = disturbance_rate**2 * period
    return Gains(*_settled_gains(kalman))


def observer_gains(bandwidth: float, mass: float, period: float) -> Gains:
    """Return the gains of an extended state observer of that bandwidth.

    Parameters
    ----------
    bandwidth : float
        rad/s.
    mass : float
        kg.
    period : float
        s.

    Returns
    -------
    Gains
        `third` belongs to the disturbance, N/m.
    """
    gains = fading_memory_gains(bandwidth, period)
    return gains._replace(third=mass * gains.third)


@lru_cache(maxsize=32)
def bias_gains(period: float, noise: float, rate_step: float) -> tuple[float, float]:
    """Return the steady Kalman gains for a slow bias and its rate.

    Parameters
    ----------
    period : float
        Between two samples, s.
    noise : float
        Standard deviation of a sample, m.
    rate_step : float
        Standard deviation of the bias's acceleration, m/s².

    Returns
    -------
    tuple of float
        Gain on the bias (1) and on its rate, 1/s.
    """
    import numpy as np
    from filterpy.common import Q_discrete_white_noise
    from filterpy.kalman import KalmanFilter

    kalman = KalmanFilter(dim_x=2, dim_z=1)
    kalman.F = np.array([[1.0, period], [0.0, 1.0]])
    kalman.H = np.array([[1.0, 0.0]])
    kalman.R = np.array([[noise * noise]])
    kalman.Q = Q_discrete_white_noise(2, period, var=rate_step**2)
    gains = _settled_gains(kalman)
    return gains[0], gains[1]


def _constant_gain_filter(
    period: float, resolution: float, third: tuple[float, float]
) -> "KalmanFilter":
    """Return a filterpy filter whose third state moves position and velocity by `third`."""
    import numpy as np
    from filterpy.kalman import KalmanFilter

    kalman = KalmanFilter(dim_x=3, dim_z=1)
    kalman.F = np.array([[1.0, period, third[0]], [0.0, 1.0, third[1]], [0.0, 0.0, 1.0]])
    kalman.H = np.array([[1.0, 0.0, 0.0]])
    kalman.R = np.array([[resolution * resolution / 12.0]])
    return kalman


def _settled_gains(kalman: "KalmanFilter") -> tuple[float, ...]:
    """Step the filter's covariance until its gains stand still."""
    kalman.P = kalman.Q * 1e3
    before = (0.0,) * kalman.dim_x
    for _ in range(_MOST_STEPS):
        kalman.predict()
        kalman.update(0.0)
        gains = tuple(float(value) for value in kalman.K[:, 0])
        if all(abs(new - old) <= 1e-9 * abs(new) for new, old in zip(gains, before, strict=True)):
            return gains
        before = gains
    raise ValueError(
        f"the Kalman gains do not settle within {_MOST_STEPS} steps: the noise of the process "
        "is too small for the noise of the measurement"
    )


class MotionEstimator(PlainNumbers):
    """Position, velocity and acceleration of whatever an encoder measures.

    Parameters
    ----------
    gains : Gains
        From `motion_gains` or `fading_memory_gains`.
    period : float
        s.
    """

    def __init__(self, gains: Gains, period: float) -> None:
        self._gain_x, self._gain_v, self._gain_a = gains
        self._period = period
        self.position = 0.0
        """m, at the time of the last reading."""
        self.velocity = 0.0
        """m/s."""
        self.acceleration = 0.0
        """m/s²."""

    def reset(self, position: float) -> None:
        """Start at rest at a measured position, m."""
        self.position = position
        self.velocity = self.acceleration = 0.0

    def update(self, position: float) -> None:
        """Take the next reading, m."""
        period = self._period
        acceleration = self.acceleration
        velocity = self.velocity
        predicted = self.position + period * (velocity + 0.5 * period * acceleration)
        error = position - predicted
        self.position = predicted + self._gain_x * error
        self.velocity = velocity + period * acceleration + self._gain_v * error
        self.acceleration = acceleration + self._gain_a * error

    def predict(self, ahead: float) -> tuple[float, float]:
        """Return position (m) and velocity (m/s) `ahead` seconds after the last reading."""
        gained = ahead * self.acceleration
        return self.position + ahead * (self.velocity + 0.5 * gained), self.velocity + gained


class ForceObserver(PlainNumbers):
    """Position, velocity and disturbance of a mass that a measured force drives.

    ``M x'' = F + d``: everything that the force does not explain, friction above all, is d.

    Parameters
    ----------
    gains : Gains
        From `disturbance_gains` (Kalman) or `observer_gains` (extended state observer).
    mass : float
        M, kg.
    period : float
        s.

    References
    ----------
    J. Han, "From PID to active disturbance rejection control", IEEE Trans. Ind. Electron. 56(3),
    2009 (the extended state observer), here fed with the measured force.
    """

    def __init__(self, gains: Gains, mass: float, period: float) -> None:
        self._gain_x, self._gain_v, self._gain_d = gains
        self._per_mass = 1.0 / mass
        self._period = period
        self._force = 0.0
        self.position = 0.0
        """m, at the time of the last reading."""
        self.velocity = 0.0
        """m/s."""
        self.disturbance = 0.0
        """N, against or with the force, positive along the position."""

    def reset(self, position: float, force: float) -> None:
        """Start at rest at a measured position (m): the disturbance balances the force (N)."""
        self.position = position
        self.velocity = 0.0
        self.disturbance = -force
        self._force = force

    def update(self, position: float, force: float) -> None:
        """Take the next readings: position (m) and force (N), of the same moment."""
        period = self._period
        mean_force = 0.5 * (self._force + force)
        gained = period * self._per_mass * (mean_force + self.disturbance)
        predicted = self.position + period * (self.velocity + 0.5 * gained)
        error = position - predicted
        self.position = predicted + self._gain_x * error
        self.velocity += gained + self._gain_v * error
        self.disturbance += self._gain_d * error
        self._force = force

    def predict(self, ahead: float) -> tuple[float, float]:
        """Return position (m) and velocity (m/s) `ahead` seconds after the last readings."""
        gained = ahead * self._per_mass * (self._force + self.disturbance)
        return self.position + ahead * (self.velocity + 0.5 * gained), self.velocity + gained


class StandstillDetector(PlainNumbers):
    """A detector of standstill: less than a distance has been moved within a time.

    Parameters
    ----------
    distance : float
        m; a few encoder steps.
    time : float
        s.
    period : float
        The loop's period, s.
    """

    def __init__(self, distance: float, time: float, period: float) -> None:
        self._distance = distance
        self._cycles = max(1, round(time / period))
        self._anchor = 0.0
        self._count = 0

    def reset(self, position: float) -> None:
        """Start at a position (m), not yet known to stand still."""
        self._anchor = position
        self._count = 0

    def update(self, position: float) -> bool:
        """Take the next reading (m) and return whether it stands still."""
        if abs(position - self._anchor) > self._distance:
            self._anchor = position
            self._count = 0
            return False
        self._count += 1
        if self._count < self._cycles:
            return False
        if self._count >= 2 * self._cycles:
            # Creeping is standing still: the anchor comes along.
            self._anchor = position
            self._count = self._cycles
        return True
