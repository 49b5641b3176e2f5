"""Ways of pressures against numpy's own deviation, over stretches that are cut by hand."""

import math

import numpy as np
import pytest

from rig.mechanisms.pneumatic.alarms.ways import PressureWays


@pytest.mark.parametrize("seed", range(5))
def test_the_way_gone_is_the_rms_over_that_of_a_healthy_one(seed):
    rng = np.random.default_rng(seed)
    ways, rows, now = PressureWays(0.1), [], 0.0
    for _ in range(300):
        now += rng.uniform(1e-3, 2e-3)
        shown, healthy = rng.normal(200e3, 30e3, 3), rng.normal(150e3, 40e3, 3)
        ways.note(now, tuple(shown), tuple(healthy))
        rows.append((now, shown, healthy))
    last = [row for row in rows if now - row[0] <= 0.1]
    for k in range(3):
        gone, wanted = (np.std([row[which][k] for row in last]) for which in (1, 2))
        assert ways.share_gone(k, 1e3) == pytest.approx(gone / wanted, rel=1e-9)


def test_what_a_healthy_one_hardly_moves_shows_nothing():
    ways = PressureWays(1.0)
    for k in range(100):
        way = 5e3 * (-1.0) ** k
        ways.note(1e-3 * k, (0.3 * way + 7e3,), (way,))
    assert ways.share_gone(0, math.nextafter(5e3, 0.0)) == pytest.approx(0.3)
    assert math.isnan(ways.share_gone(0, 5e3))


def test_what_was_before_a_pause_is_forgotten():
    ways = PressureWays(1.0)
    ways.note(0.0, (300.0,), (0.0,))
    ways.clear()
    for k, pressure in enumerate((100.0, 104.0)):
        ways.note(0.5 + 1e-3 * k, (pressure,), (0.5 * pressure,))
    assert ways.share_gone(0, 0.1) == 2.0


def test_what_is_as_old_as_the_stretch_counts():
    ways = PressureWays(0.5)
    for now, pressure in ((0.0, 7.0), (0.25, 5.0), (0.75, 1.0)):
        ways.note(now, (pressure,), (2.0 * pressure,))
    assert ways.share_gone(0, 3.9) == 0.5  # of 5 and 1: 7 is gone, or they went farther
    assert math.isnan(ways.share_gone(0, 4.0))
    assert ways.follows(0, 3.9) == 0.5
    assert math.isnan(ways.follows(0, 4.0))


@pytest.mark.parametrize("seed", range(5))
def test_who_follows_is_told_by_the_slope_over_a_healthy_one(seed):
    rng = np.random.default_rng([seed, 2])
    ways = PressureWays(1.0)
    shown, healthy = rng.normal(200e3, 30e3, (2, 100))
    for k in range(100):
        ways.note(1e-3 * k, (shown[k], 0.4 * healthy[k]), (healthy[k], healthy[k]))
    assert ways.follows(0, 1e3) == pytest.approx(np.polyfit(healthy, shown, 1)[0], rel=1e-6)
    assert ways.follows(1, 1e3) == pytest.approx(0.4, rel=1e-6)
    assert math.isnan(ways.follows(1, 60e3))


def test_what_goes_far_its_own_way_does_not_follow():
    ways = PressureWays(1.0)
    for k in range(100):
        ways.note(1e-3 * k, (300.0 * k,), (10e3 * math.sin(0.2 * math.pi * k),))
    assert ways.share_gone(0, 1e3) > 1.0
    assert abs(ways.follows(0, 1e3)) < 0.3


@pytest.mark.parametrize("seed", range(5))
def test_what_comes_late_is_where_a_healthy_one_has_been_and_not_beyond(seed):
    rng = np.random.default_rng([seed, 3])
    ways = PressureWays(0.05)
    healthy = rng.normal(150e3, 40e3, (200, 2))
    for k, row in enumerate(healthy):
        ways.note(1e-3 * k, (healthy[max(k - 20, 0)][0], rng.normal(150e3, 90e3)), tuple(row))
    low, high = healthy[-51:, 0].min(), healthy[-51:, 0].max()
    assert ways.beyond(0) == 0.0
    for far in rng.uniform(1.0, 90e3, 4):
        for shown, wanted in ((high + far, far), (low - far, far), (high, 0.0), (low, 0.0)):
            ways.note(0.2, (shown, 0.0), (150e3, 0.0))
            assert ways.beyond(0) == pytest.approx(wanted, abs=1e-6)
            ways._past.pop()
