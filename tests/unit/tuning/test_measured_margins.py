"""Margins of a loop that is known at some frequencies, against loops that can be solved by hand."""

import math
import random

import numpy as np
import pytest

from rig.cli.margins import doubts_about
from rig.hal.measured_loop import MeasuredLoop, margins_of

DRAWN = random.Random(90210)
FREQUENCIES = np.array([2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 24, 28, 32, 36, 40.0])


def integrator(crossover, delay):
    w = 2j * math.pi * FREQUENCIES
    return crossover / w * np.exp(-w * delay)


def least_distance(crossover, delay):
    """Return how near an integrator with dead time comes to -1, on a grid of its own."""
    w = np.linspace(4.0 * math.pi, 80.0 * math.pi, 200_001)
    return float(np.min(np.abs(1.0 + crossover / (1j * w) * np.exp(-1j * w * delay))))


@pytest.mark.parametrize(
    ("crossover", "delay"),
    [(DRAWN.uniform(20.0, 120.0), DRAWN.uniform(0.0, 8e-3)) for _ in range(12)],
)
def test_an_integrator_with_dead_time(crossover, delay):
    found = margins_of(FREQUENCIES, integrator(crossover, delay))
    assert found.crossover == pytest.approx(crossover, rel=0.01)
    assert found.phase == pytest.approx(math.pi / 2.0 - crossover * delay, rel=0.01)
    assert found.delay == pytest.approx(math.pi / 2.0 / crossover - delay, rel=0.02)
    assert found.sensitivity == pytest.approx(1.0 / least_distance(crossover, delay), rel=0.02)


def test_where_no_gain_of_1_was_seen_crossover_and_delay_are_not_known():
    found = margins_of(FREQUENCIES, 0.02 * integrator(10.0, 0.0))
    assert all(map(math.isnan, (found.crossover, found.phase, found.delay)))
    assert 0.9 < found.sensitivity < 1.1
    for gain, told in ((0.02, False), (1.0, True)):
        loop = gain * integrator(60.0, 0.0)
        assert MeasuredLoop(FREQUENCIES, loop, loop[None], loop).tells_crossover is told


@pytest.mark.parametrize(
    ("gain", "last", "said"),
    [
        (0.02, 15, ["from 2 Hz to 40 Hz, where the loop is known, its gain is nowhere 1"]),
        (1.0, 15, []),
        (1.0, 8, ["above 16 Hz the loop could not be told from noise"]),
    ],
)
def test_what_is_not_known_of_a_loop_is_said(gain, last, said):
    f, loop = FREQUENCIES[:last], gain * integrator(60.0, 0.0)[:last]
    doubts = list(doubts_about(MeasuredLoop(f, loop, loop[None], loop)))
    assert len(doubts) == len(said)
    assert all(doubt.startswith(words) for doubt, words in zip(doubts, said, strict=True))


@pytest.mark.parametrize(("known", "is_partial"), [(slice(1, 4), True), (slice(0, 8), False)])
def test_a_loop_of_a_small_part_of_the_shake_does_not_pose_as_the_whole(known, is_partial):
    f, loop = FREQUENCIES[known], integrator(60.0, 0.0)[known]
    measured = MeasuredLoop(f, loop, loop[None], loop, FREQUENCIES)
    assert measured.is_partial is is_partial
    said = [doubt for doubt in doubts_about(measured, "rig margins …") if "a shake" in doubt]
    assert len(said) == is_partial
    if said:
        assert "of a shake from 2 Hz to 40 Hz the loop is told from 4 Hz to 8 Hz alone" in said[0]
        assert "a greater sensitivity may lie outside" in said[0] and "may be smaller" in said[0]
        assert said[0].endswith("with a smaller shake more of it may be told: rig margins …")


def with_noise(scatter):
    loop, generator = integrator(60.0, 4e-3), np.random.default_rng(4)
    noise = generator.normal(size=(200, len(loop))) + 1j * generator.normal(size=(200, len(loop)))
    drawn = loop + scatter * np.abs(loop) * noise / math.sqrt(2.0)
    return MeasuredLoop(FREQUENCIES, loop, drawn, loop)


def test_what_noise_hides_is_left_out_at_both_ends_and_nowhere_else():
    scatter = np.full(len(FREQUENCIES), 0.1)
    scatter[[0, 1, 12, 14]] = 0.8
    known = with_noise(scatter).known(0.5)
    assert known.frequencies.tolist() == FREQUENCIES[2:12].tolist()
    assert known.drawn.shape == (200, 10) and not known.is_partial
    assert known.shaken.tolist() == FREQUENCIES.tolist()
    with pytest.raises(ValueError, match="cannot be told from noise"):
        with_noise(np.full(len(FREQUENCIES), 0.8)).known(0.5)
    with pytest.raises(ValueError, match="cannot be told from noise"):
        with_noise(np.where(FREQUENCIES < 5.0, 0.1, 0.8)).known(0.5)


def test_an_interval_is_as_wide_as_what_was_drawn():
    loop = integrator(60.0, 4e-3)
    drawn = np.array([loop * scale for scale in np.linspace(0.9, 1.1, 201)])
    measured = MeasuredLoop(FREQUENCIES, loop, drawn, loop)
    low, high = measured.interval("crossover")
    assert low == pytest.approx(60.0 * 0.905, rel=0.01)
    assert high == pytest.approx(60.0 * 1.095, rel=0.01)
    assert low < measured.margins.crossover < high
