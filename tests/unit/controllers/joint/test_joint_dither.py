"""Dither in the tensions that turn nothing, and along the path."""

import math

import numpy as np
import pytest

from controllers.spherical_joint.dither import (
    DitherSettings,
    PathDither,
    PathDitherSettings,
    TensionDither,
)
from controllers.spherical_joint.types import JointModel

PERIOD = 1e-3
MODEL = JointModel()


def shake(settings, speed, count=2000):
    """Return the dither from its start on; it is whole after some 2 s."""
    dither = TensionDither(settings, MODEL, PERIOD)
    return np.array([dither.update(speed) for _ in range(count)])


def test_dither_is_a_sine_of_its_amplitude_and_frequency():
    found = shake(DitherSettings(amplitude=100e3, frequency=20.0), 0.0, 4000)[2000:]
    assert found.max() == pytest.approx(4.0 * MODEL.area * 100e3, rel=3e-3)
    assert found.mean() == pytest.approx(0.0, abs=1e-3)
    assert np.abs(np.fft.rfft(found)).argmax() == 40


def test_dither_grows_from_nothing():
    found = np.abs(shake(DitherSettings(amplitude=100e3, frequency=20.0), 0.0, 1000))
    whole = 4.0 * MODEL.area * 100e3
    assert found[0] < 1e-3 * whole
    assert np.abs(np.diff(found[:25])).max() < 0.02 * whole
    assert found[-100:].max() > 0.98 * whole


def test_dither_fades_with_the_speed_of_the_wires():
    settings = DitherSettings(amplitude=100e3, fade_speed=10e-3)
    still, slow, fast = (np.ptp(shake(settings, speed)) for speed in (0.0, 10e-3, 30e-3))
    assert slow == pytest.approx(still / math.e, rel=1e-6)
    assert fast < 1e-3 * still


def test_no_amplitude_is_no_dither():
    assert not shake(DitherSettings(), 0.0).any()
    assert TensionDither(DitherSettings(), MODEL, PERIOD).tension == 0.0


def test_what_the_regulators_let_through():
    """A second-order response of 40 rad/s and damping 1 passes 1 / (1 + (w / 40)²)."""
    dither = TensionDither(DitherSettings(amplitude=100e3, frequency=20.0), MODEL, PERIOD)
    passed = 1.0 / (1.0 + (2.0 * math.pi * 20.0 / 40.0) ** 2)
    assert dither.tension == pytest.approx(MODEL.area * 100e3 * passed)


def test_dither_starts_anew_on_reset():
    dither = TensionDither(DitherSettings(amplitude=1e3), MODEL, PERIOD)
    first = [dither.update(0.0) for _ in range(7)]
    dither.reset()
    assert [dither.update(0.0) for _ in range(7)] == first


def shake_along(settings, first, second, count=4000):
    """Return the forces of both pairs once the dither is whole."""
    dither = PathDither(settings, PERIOD)
    return np.array([dither.update(first, second) for _ in range(count)])[2000:]


@pytest.mark.parametrize("direction", [0.0, 0.4, 2.0, 4.5])
def test_path_dither_points_along_the_path(direction):
    settings = PathDitherSettings(force=1.5, frequency=50.0, fade_speed=1.0)
    speed = 20e-3
    first, second = math.cos(direction), math.sin(direction)
    found = shake_along(settings, speed * first, speed * second)
    across = found @ [-second, first]
    along = found @ [first, second]
    assert np.abs(across).max() < 1e-12
    assert along.max() == pytest.approx(1.5, rel=0.03)
    assert np.abs(np.fft.rfft(along)).argmax() == 100


def test_path_dither_goes_where_the_path_has_no_direction_and_where_seals_slide():
    settings = PathDitherSettings(force=1.5, fade_speed=15e-3)
    rests, creeps, slides, flies = (
        np.abs(shake_along(settings, speed, 0.0)).max() for speed in (0.0, 0.2e-3, 8e-3, 45e-3)
    )
    assert rests == 0.0
    assert creeps < 0.5 * slides
    assert flies < 1e-3 * slides


def test_path_dither_grows_from_nothing_and_starts_anew_on_reset():
    dither = PathDither(PathDitherSettings(force=1.5), PERIOD)
    first = [dither.update(10e-3, 0.0) for _ in range(1000)]
    assert max(abs(force) for force, _ in first[:3]) < 0.02
    assert max(force for force, _ in first[-100:]) > 1.3
    dither.reset()
    assert [dither.update(10e-3, 0.0) for _ in range(1000)] == first


def test_no_force_is_no_path_dither():
    assert PathDither(PathDitherSettings(), PERIOD).update(10e-3, 0.0) == (0.0, 0.0)
