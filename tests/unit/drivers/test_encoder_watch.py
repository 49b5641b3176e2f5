"""The watch of a servo's encoder: blind to what a drive does not tell, and calm in sound motion."""

import math

import numpy as np
import pytest

from drivers.servos.encoder_watch import EncoderWatch

PERIOD = 5e-3
STEP = 2e-4
DRAWN = np.random.default_rng(44).uniform(size=(8, 3)).tolist()


def looks(angle, speed, duration=2.0):
    """Return what the watch says of a position and a velocity over time, once each."""
    watch = EncoderWatch(STEP)
    times = np.arange(0.0, duration, PERIOD)
    return {watch.look(t, round(angle(t) / STEP) * STEP, speed(t)) for t in times} - {None}


@pytest.mark.parametrize("drawn", DRAWN)
def test_a_drive_that_tells_no_velocity_is_not_blamed(drawn):
    size, rate = 0.05 + drawn[0], 1.0 + 4.0 * drawn[1]
    assert not looks(lambda t: size * math.sin(rate * t), lambda t: 0.0)


@pytest.mark.parametrize("drawn", DRAWN)
def test_a_sound_sine_is_not_blamed_though_the_velocity_is_a_third_too_great(drawn):
    size, rate, scale = 0.05 + drawn[0], 1.0 + 4.0 * drawn[1], 1.0 + drawn[2] / 3.0
    said = looks(
        lambda t: size * math.sin(rate * t), lambda t: scale * size * rate * math.cos(rate * t)
    )
    assert not said


@pytest.mark.parametrize("drawn", DRAWN)
def test_a_motor_that_runs_from_under_a_resting_position_is_found(drawn):
    wander = math.copysign(0.06 + 0.09 * drawn[0], drawn[1] - 0.5)
    said = looks(lambda t: 0.3, lambda t: wander)
    assert said
    assert all("encoder wanders" in sentence for sentence in said)


@pytest.mark.parametrize("drawn", DRAWN)
def test_a_joint_that_rattles_between_two_samples_is_not_called_mirrored(drawn):
    generator = np.random.default_rng(int(1e6 * drawn[0]))
    speeds = generator.uniform(1.0, 6.0, 400) * (-1.0) ** np.arange(400)  # there and back
    angles = 0.01 * generator.uniform(-1.0, 1.0, 400)
    said = looks(lambda t: angles[round(t / PERIOD)], lambda t: speeds[round(t / PERIOD)], 1.9)
    assert not {sentence for sentence in said if "mirrored" in sentence}


@pytest.mark.parametrize("drawn", DRAWN)
def test_a_joint_that_is_struck_again_and_again_between_two_samples_is_not_called_mirrored(drawn):
    """A foot rattles on the floor: it swings back from blow to blow, which no velocity shows."""
    speed, every = 0.3 + 0.2 * drawn[0], 3
    blow = -(2.0 + drawn[1]) * every * speed * PERIOD

    def angle(t):
        return speed * t + blow * (round(t / PERIOD) // every)

    assert not {said for said in looks(angle, lambda t: speed, 0.5) if "mirrored" in said}


@pytest.mark.parametrize("drawn", DRAWN)
def test_a_position_that_goes_against_a_steady_motor_is_called_mirrored(drawn):
    size, rate = 0.05 + drawn[0], 1.0 + 4.0 * drawn[1]
    said = looks(lambda t: -size * math.sin(rate * t), lambda t: size * rate * math.cos(rate * t))
    assert any("mirrored" in sentence for sentence in said)
