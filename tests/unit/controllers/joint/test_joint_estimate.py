"""The marker from encoders and a late camera."""

import math

import numpy as np
import pytest

from controllers.estimators import bias_gains
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.marker_estimate import MarkerEstimateSettings, MarkerEstimator
from controllers.spherical_joint.poses import axis_from_tilt
from controllers.spherical_joint.types import CameraSample
from controllers.spherical_joint.wires import InverseKinematics

GEOMETRY = SphericalJointGeometry()
INVERSE = InverseKinematics(GEOMETRY)
PERIOD = 1e-3


def circle(t, frequency=0.5):
    return axis_from_tilt(math.radians(20.0), 2.0 * math.pi * frequency * t)


def estimate_circle(
    latency, *, bias=(1e-4, -5e-5, 2e-5), noise=0.0, stamp_error=0.0, frames=60.0, dropped=()
):
    """Return the error of the estimate over the second half of two seconds, m (n, 3)."""
    estimator = MarkerEstimator(MarkerEstimateSettings(), GEOMETRY, PERIOD)
    generator = np.random.default_rng(0)
    waiting, newest, errors, frame = [], None, [], 0
    for k in range(2000):
        t = k * PERIOD
        true = np.subtract(GEOMETRY.marker(circle(t)), bias)
        if t >= frame / frames:
            exposed = frame / frames
            seen = np.subtract(GEOMETRY.marker(circle(exposed)), bias)
            seen = seen + noise * generator.standard_normal(3)
            if frame not in dropped:
                sample = CameraSample(tuple(seen.tolist()), exposed + stamp_error)
                waiting.append((exposed + latency, sample))
            frame += 1
        while waiting and waiting[0][0] <= t:
            newest = waiting.pop(0)[1]
        estimate = estimator.update(t, INVERSE.shortening(circle(t)), newest)
        if k >= 1000:
            errors.append(np.subtract(estimate.marker, true))
    return np.array(errors), estimate


def rms(errors):
    return math.sqrt(np.mean(np.sum(np.square(errors), axis=1)))


@pytest.mark.parametrize("latency", [0.0, 0.02, 0.04, 0.1])
def test_a_late_camera_costs_nothing_but_its_age(latency):
    errors, estimate = estimate_circle(latency)
    assert rms(errors) < 1e-7
    assert estimate.bias == pytest.approx((1e-4, -5e-5, 2e-5), abs=1e-7)
    assert latency <= estimate.camera_age + 1e-9 < latency + 0.02
    assert not estimate.alarms


def test_a_wrong_stamp_costs_the_way_that_the_marker_goes_in_it():
    """57 mm/s at 0.5 Hz: 1 ms is 0.06 mm."""
    errors, _ = estimate_circle(0.04, stamp_error=1e-3)
    assert rms(errors) == pytest.approx(57e-6, rel=0.1)


def test_noise_of_the_camera_is_averaged():
    errors, _ = estimate_circle(0.04, noise=30e-6)
    assert 2e-6 < rms(errors) < 30e-6 * math.sqrt(3.0)


def test_dropped_frames_do_not_matter_to_a_slow_bias():
    errors, _ = estimate_circle(0.04, dropped=set(range(20, 100, 3)))
    assert rms(errors) < 1e-6


def test_without_a_camera_the_encoders_speak():
    estimator = MarkerEstimator(MarkerEstimateSettings(), GEOMETRY, PERIOD)
    estimate = estimator.update(0.0, INVERSE.shortening(circle(0.3)))
    assert estimate.marker == estimate.encoder_marker
    assert estimate.marker == pytest.approx(GEOMETRY.marker(circle(0.3)), abs=1e-10)
    assert estimate.camera_age == math.inf


def test_samples_between_two_cycles_are_compared_in_between():
    estimator = MarkerEstimator(MarkerEstimateSettings(), GEOMETRY, PERIOD)
    for k in range(40):
        estimator.update(k * PERIOD, INVERSE.shortening(circle(k * PERIOD)))
    exposed = 17.6 * PERIOD
    sample = CameraSample(GEOMETRY.marker(circle(exposed)), exposed)
    estimate = estimator.update(40 * PERIOD, INVERSE.shortening(circle(40 * PERIOD)), sample)
    assert estimate.bias == pytest.approx((0.0, 0.0, 0.0), abs=3e-8)


def test_alarms():
    settings = MarkerEstimateSettings()
    estimator = MarkerEstimator(settings, GEOMETRY, PERIOD)
    home = (0.0, 0.0, 0.0, 0.0)
    marker = GEOMETRY.marker((0.0, 0.0, 1.0))

    for k in range(300):
        assert not estimator.update(k * PERIOD, home).alarms
    slack = estimator.update(0.3, (2e-3, 0.0, 0.0, 0.0))
    assert slack.alarms == ("residual",)
    old = estimator.update(0.301, home, CameraSample(marker, 0.05))
    assert old.alarms == ("late",)
    assert old.marker == old.encoder_marker
    elsewhere = CameraSample((marker[0] + 3e-3, *marker[1:]), 0.3)
    assert estimator.update(0.302, home, elsewhere).alarms == ("bias",)


def test_a_camera_that_was_away_starts_anew():
    estimator = MarkerEstimator(MarkerEstimateSettings(), GEOMETRY, PERIOD)
    home, marker = (0.0, 0.0, 0.0, 0.0), GEOMETRY.marker((0.0, 0.0, 1.0))
    sample = None
    for k in range(2001):
        t = k * PERIOD
        if k % 16 == 0 and k < 200:
            # A drift that would lead far astray if it were carried on.
            sample = CameraSample((marker[0] - 1e-3 * t, *marker[1:]), t)
        if k == 2000:
            sample = CameraSample(marker, t)
        estimate = estimator.update(t, home, sample)
        assert estimate.bias[0] < 0.45e-3
    assert estimate.bias == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_bias_gains_follow_noise_and_drift():
    steady = bias_gains(1 / 60, 30e-6, 1e-3)
    quick = bias_gains(1 / 60, 30e-6, 50e-3)
    assert 0.0 < steady[0] < quick[0] < 1.0
    assert 0.0 < steady[1] < quick[1]
