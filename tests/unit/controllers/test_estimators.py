import subprocess
import sys

import numpy as np
import pytest
from filterpy.common import Q_discrete_white_noise
from filterpy.kalman import KalmanFilter

from controllers.estimators import (
    ForceObserver,
    Gains,
    MotionEstimator,
    StandstillDetector,
    disturbance_gains,
    fading_memory_gains,
    motion_gains,
    observer_gains,
)

PERIOD = 1e-3
MASS = 0.138
RESOLUTION = 1e-6


def test_all_poles_of_the_fading_memory_filter_are_where_asked():
    bandwidth = 300.0
    gains = np.array(fading_memory_gains(bandwidth, PERIOD))
    F = np.array([[1, PERIOD, PERIOD**2 / 2], [0, 1, PERIOD], [0, 0, 1]])
    closed = (np.eye(3) - np.outer(gains, [1, 0, 0])) @ F
    # A triple root moves with the cube root of rounding errors; its polynomial does not.
    pole = np.exp(-bandwidth * PERIOD)
    assert np.poly(closed) == pytest.approx(np.poly([pole] * 3), abs=1e-9)


def drive(seed=0, count=400):
    """Return readings of a mass under a random force and a slow disturbance."""
    rng = np.random.default_rng(seed)
    force = np.cumsum(rng.normal(0.0, 0.05, count))
    disturbance = 0.5 * np.sin(np.arange(count) * 0.02)
    mean = np.concatenate([[force[0] / 2], (force[1:] + force[:-1]) / 2])
    x = v = 0.0
    positions = []
    for k in range(count):
        a = (mean[k] + disturbance[k]) / MASS
        x += PERIOD * v + PERIOD**2 / 2 * a
        v += PERIOD * a
        positions.append(round(x / RESOLUTION) * RESOLUTION)
    return positions, force.tolist(), mean


def test_force_observer_at_steady_gain_agrees_with_filterpys_own_filter():
    positions, forces, means = drive()
    gains = disturbance_gains(PERIOD, RESOLUTION, MASS, 0.065, 30.0)
    observer = ForceObserver(gains, MASS, PERIOD)
    observer.reset(0.0, 0.0)

    kalman = KalmanFilter(dim_x=3, dim_z=1, dim_u=1)
    half, step = PERIOD**2 / 2 / MASS, PERIOD / MASS
    kalman.F = np.array([[1, PERIOD, half], [0, 1, step], [0, 0, 1]])
    kalman.B = np.array([[half], [step], [0.0]])
    kalman.H = np.array([[1.0, 0.0, 0.0]])
    kalman.R = np.array([[RESOLUTION**2 / 12]])
    kalman.Q = kalman.B @ kalman.B.T * 0.065**2 + np.diag([0, 0, 30.0**2 * PERIOD])
    kalman.x = np.zeros((3, 1))
    kalman.P = kalman.Q
    for position, force, mean in zip(positions, forces, means, strict=True):
        observer.update(position, force)
        kalman.predict(u=np.array([[mean]]))
        kalman.update(position)
    estimate = (observer.position, observer.velocity, observer.disturbance)
    assert estimate == pytest.approx(tuple(kalman.x[:, 0]), rel=1e-6)


def test_motion_estimator_at_steady_gain_agrees_with_filterpys_own_filter():
    positions, _, _ = drive(1)
    estimator = MotionEstimator(motion_gains(PERIOD, RESOLUTION, 0.5), PERIOD)
    estimator.reset(0.0)
    kalman = KalmanFilter(dim_x=3, dim_z=1)
    kalman.F = np.array([[1, PERIOD, PERIOD**2 / 2], [0, 1, PERIOD], [0, 0, 1]])
    kalman.H = np.array([[1.0, 0.0, 0.0]])
    kalman.R = np.array([[RESOLUTION**2 / 12]])
    kalman.Q = Q_discrete_white_noise(3, PERIOD, var=0.25)
    kalman.x = np.zeros((3, 1))
    for position in positions:
        estimator.update(position)
        kalman.predict()
        kalman.update(position)
    estimate = (estimator.position, estimator.velocity, estimator.acceleration)
    assert estimate == pytest.approx(tuple(kalman.x[:, 0]), rel=1e-6)


def test_velocity_is_better_than_a_backward_difference():
    """For 1 µm and smooth motion 0.22 against 0.40 mm/s are possible."""
    t = np.arange(0.0, 5.0, PERIOD)
    w = 2 * np.pi * 0.2
    positions = np.round(8.727e-3 * np.cos(w * t) / RESOLUTION) * RESOLUTION
    velocities = -8.727e-3 * w * np.sin(w * t)
    estimator = MotionEstimator(motion_gains(PERIOD, RESOLUTION, 0.03**0.5), PERIOD)
    estimator.reset(float(positions[0]))
    estimates = []
    for position in positions.tolist():
        estimator.update(position)
        estimates.append(estimator.velocity)
    error = np.sqrt(np.mean((np.array(estimates) - velocities)[500:] ** 2))
    difference = np.diff(positions, prepend=positions[0]) / PERIOD
    backward = np.sqrt(np.mean((difference - velocities)[500:] ** 2))
    assert backward == pytest.approx(0.40e-3, rel=0.1)
    assert error < 0.25e-3


def test_extended_state_observer_finds_a_constant_disturbance():
    observer = ForceObserver(observer_gains(600.0, MASS, PERIOD), MASS, PERIOD)
    observer.reset(0.0, 5.0)
    assert observer.disturbance == -5.0
    x = v = 0.0
    for _ in range(40):
        a = (5.0 - 3.0) / MASS
        x += PERIOD * v + PERIOD**2 / 2 * a
        v += PERIOD * a
        observer.update(x, 5.0)
    assert observer.disturbance == pytest.approx(-3.0, abs=1e-3)
    assert observer.velocity == pytest.approx(v, abs=1e-5)


def test_prediction_over_a_delay_is_exact_for_a_constant_force():
    observer = ForceObserver(Gains(0.0, 0.0, 0.0), MASS, PERIOD)
    observer.reset(1e-3, 2.0)
    observer.disturbance = -0.62  # 10 m/s²
    observer.velocity = 0.1
    assert observer.predict(2e-3) == pytest.approx((1e-3 + 2e-4 + 2e-5, 0.12))


def test_standstill_is_moving_less_than_a_distance_within_a_time():
    detector = StandstillDetector(5e-6, 0.04, PERIOD)
    detector.reset(1e-3)
    # 40 cycles at rest; then 0.1 mm/s is 4 µm in 40 ms, a creep; 0.3 mm/s is sliding.
    assert [detector.update(1e-3) for _ in range(41)] == [False] * 39 + [True] * 2
    creep = [detector.update(1e-3 + k * 1e-7) for k in range(1, 400)]
    assert all(creep)
    slide = [detector.update(1.04e-3 + k * 3e-7) for k in range(1, 400)]
    assert not any(slide[40:])


def test_a_filter_that_cannot_settle_says_so():
    with pytest.raises(ValueError, match="do not settle"):
        motion_gains(PERIOD, 1.0, 1e-9)


def test_filterpy_is_imported_only_to_design_a_filter():
    code = (
        "import sys, controllers.cylinder.super_twisting, controllers.cylinder.pid_friction;"
        "sys.exit('filterpy' in sys.modules or 'scipy' in sys.modules or 'numpy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
