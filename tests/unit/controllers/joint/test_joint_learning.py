"""Learning over laps on rigs small enough to be understood."""

import math

import numpy as np
import pytest

from controllers.spherical_joint.learning import (
    LapLearning,
    LapMemory,
    LearningSettings,
    StopSettings,
)
from controllers.spherical_joint.types import Lap

PERIOD = 1e-3
TICKS = 1000
LEARNING, STOP = LearningSettings(), StopSettings()


def learn(disturbance, laps, settings=LEARNING, stop=STOP, delay=0, sign=1.0):
    """Learn against a disturbance; return the errors (laps, ticks) and the learning."""
    memory = LapMemory(settings, 1, PERIOD)
    learning = LapLearning(stop, (memory,))
    applied, errors = [0.0] * delay, np.zeros((laps, TICKS))
    for lap in range(laps):
        for tick in range(TICKS):
            learning.start_cycle(Lap(lap, tick, TICKS))
            applied.append(memory.at(tick)[0])
            error = disturbance(lap, tick) - sign * applied[-1 - delay]
            memory.learn(tick, (error,))
            learning.add_score(error * error)
            errors[lap, tick] = error
    return errors, learning, memory


def wave(lap, tick):
    return math.sin(2.0 * math.pi * 3.0 * tick / TICKS) + 0.3


def rms(errors):
    return np.sqrt(np.mean(np.square(errors), axis=1))


def test_what_repeats_is_learnt_lap_by_lap():
    errors, _, _ = learn(wave, 8, LearningSettings(advance=0.0))
    found = rms(errors)
    # Each lap leaves 1 - gain of it.
    assert found[1:5] / found[:4] == pytest.approx([0.6] * 4, abs=0.04)


def test_the_advance_makes_up_for_the_time_the_rig_takes():
    late, _, _ = learn(wave, 8, LearningSettings(advance=0.0), delay=60)
    right, _, _ = learn(wave, 8, LearningSettings(advance=60e-3), delay=60)
    assert rms(right)[7] < 0.08 * rms(right)[0]
    assert rms(late)[7] > 3.0 * rms(right)[7]


def test_a_lap_has_no_seam():
    errors, _, memory = learn(wave, 12, LearningSettings(advance=20e-3), delay=20)
    table = [memory.at(tick)[0] for tick in range(TICKS)]
    assert max(abs(a - b) for a, b in zip(table, [*table[1:], table[0]], strict=True)) < 0.06
    assert np.abs(errors[11]).max() < 0.06


@pytest.mark.parametrize(("frequency", "passed"), [(2.0, 0.99), (20.0, 0.707), (60.0, 0.0)])
def test_q_passes_half_of_the_power_at_its_bandwidth_without_phase(frequency, passed):
    def tone(lap, tick):
        return math.cos(2.0 * math.pi * frequency * tick * PERIOD)

    _, _, memory = learn(tone, 2, LearningSettings(gain=1.0, advance=0.0))
    learnt = np.array([memory.at(tick)[0] for tick in range(TICKS)])
    waves = np.exp(-2j * np.pi * frequency * np.arange(TICKS) * PERIOD)
    answer = 2.0 * np.mean(learnt * waves)
    assert answer.real == pytest.approx(passed, abs=0.03)
    assert answer.imag == pytest.approx(0.0, abs=0.01)


def test_learning_stops_where_it_no_longer_helps_and_keeps_the_best():
    generator = np.random.default_rng(2)

    def noisy(lap, tick):
        return wave(lap, tick) + 0.2 * generator.standard_normal()

    errors, learning, memory = learn(noisy, 20)
    assert learning.finished
    assert 4 <= len(learning.scores) < 16
    best = min(learning.scores)
    assert rms(errors)[-1] == pytest.approx(best, rel=0.05)
    before = memory.at(500)
    memory.learn(0, (1.0,))
    assert memory.at(500) == before


def test_learning_that_makes_it_worse_ends_with_nothing_learnt():
    errors, learning, memory = learn(wave, 6, sign=-1.0)
    assert learning.finished
    assert all(memory.at(tick) == (0.0,) for tick in range(TICKS))
    assert rms(errors)[-1] == pytest.approx(rms(errors)[0])


def test_nothing_is_learnt_before_a_lap_begins_at_its_beginning():
    memory = LapMemory(LearningSettings(), 1, PERIOD)
    learning = LapLearning(StopSettings(), (memory,))
    learning.start_cycle(Lap(0, 7, TICKS))
    assert not learning.active
    learning.start_cycle(Lap(1, 0, TICKS))
    assert learning.active


def test_reset_forgets_what_was_learnt():
    _, learning, memory = learn(wave, 3)
    learning.reset()
    assert not learning.active
    assert not learning.scores
    learning.start_cycle(Lap(0, 0, TICKS))
    assert memory.at(250) == (0.0,)


def test_a_lap_shorter_than_the_filter_is_refused():
    memory = LapMemory(LearningSettings(), 1, PERIOD)
    with pytest.raises(ValueError, match="a lap of 60 cycles is too short"):
        memory.begin(60)


@pytest.mark.parametrize("lap", [Lap(0, 0, TICKS), Lap(5, 0, 2 * TICKS)], ids=["anew", "longer"])
def test_laps_of_another_motion_are_learnt_from_the_beginning(lap):
    _, learning, memory = learn(wave, 3)
    learning.start_cycle(lap)
    assert learning.active
    assert not learning.scores
    assert memory.at(250) == (0.0,)
