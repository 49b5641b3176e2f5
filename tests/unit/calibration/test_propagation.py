"""Intervals of sums of errors of different kinds."""

import numpy as np
import pytest

from rig.calibration.error_sums import half_width


def test_a_part_known_from_few_repetitions_has_students_interval():
    assert half_width(2.0, 5.0) == pytest.approx(2.0 * 2.571, rel=0.02)


def test_a_normal_part_has_the_normal_interval():
    assert half_width(0.0, 5.0, normal=3.0) == pytest.approx(3.0 * 1.960, rel=0.02)


def test_what_lies_within_bounds_is_not_looked_for_beyond_them():
    bound = 0.3
    half = half_width(0.0, 5.0, even=[bound / np.sqrt(3.0)])
    assert half == pytest.approx(0.95 * bound, rel=0.01)


def test_the_interval_of_a_sum_holds_it_as_often_as_it_says():
    rng = np.random.default_rng(5)
    parts = (0.5, 0.8, 0.3)
    sums = 0.7 * rng.standard_t(12.0, 20_000) + 0.4 * rng.standard_normal(20_000)
    sums += sum(part * np.sqrt(3.0) * rng.uniform(-1.0, 1.0, 20_000) for part in parts)
    held = np.abs(sums) <= half_width(0.7, 12.0, 0.4, parts)
    assert held.mean() == pytest.approx(0.95, abs=0.006)
