"""How long rods have stood of late, against a sum over the whole past."""

import math

import numpy as np
import pytest

from rig.mechanisms.pneumatic.alarms.rests import RodRests


def stood(places, times):
    """Return how long a rod stood and how much time passed, both fading by e in a second."""
    standing = np.zeros(len(places), bool)
    place, since = places[0], 0
    for k in range(1, len(places)):
        if abs(places[k] - place) > 30e-6:
            place, since = places[k], k
        elif times[k] - times[since] > 0.02:
            standing[since + 1 : k + 1] = True
    passed = np.diff(times)
    weights = np.exp(-(times[-1] - times[1:]))
    return (weights * passed)[standing[1:]].sum(), (weights * passed).sum()


@pytest.mark.parametrize("seed", range(6))
def test_the_share_is_that_of_a_sum_over_the_past(seed):
    rng = np.random.default_rng(seed)
    rests, places, times = RodRests(), [], []
    place, now = 7e-3, rng.uniform(0.0, 5.0)
    for _ in range(30):
        runs = rng.random() < 0.5
        for _ in range(rng.integers(10, 120)):
            place += rng.uniform(40e-6, 90e-6) if runs else 0.0
            now += 1e-3
            places.append(place + rng.uniform(-2e-6, 2e-6))
            times.append(now)
            rests.update(places[-1], now)
    one, all_of_it = stood(np.array(places), np.array(times))
    # What it stood before it was seen to stand has faded a little: 20 ms of a second at most.
    assert rests.share == pytest.approx(one / all_of_it, abs=0.02)
    assert rests.sticks is (rests.share > 0.5)


def rests_at(*cycles):
    rests = RodRests()
    for place, now in cycles:
        rests.update(place, now)
    return rests


def test_before_any_time_has_passed_nothing_has_stood():
    assert RodRests().share == rests_at((1.0, 3.0)).share == 0.0
    assert RodRests().sticks is False


def test_a_rod_stands_that_goes_no_farther_for_long_enough():
    rests = rests_at((0.0, 0.0), (30e-6, 0.02))
    assert rests.share == 0.0, "for just the time that it takes"
    rests.update(-30e-6, 0.0200001)
    assert rests.share > 0.98
    rests.update(30e-6 + 1e-9, 0.03)
    assert 0.66 < rests.share < 0.67, "a third of the time it went"
    for far in (31e-6, -31e-6):
        assert rests_at((0.0, 0.0), (far, 0.021)).share == 0.0
    gone = rests_at((0.0, 0.0), (0.0, 0.03), (1.0, 0.06), (1.0, 0.07))
    assert 0.42 < gone.share < 0.44, "it has not stood where it went to for long enough"


def test_what_was_long_ago_fades():
    rests = rests_at((0.0, 0.0), (0.0, 1.0))
    assert rests.share == 1.0
    rests.update(1.0, 2.0)
    kept = math.exp(-1.0)
    assert rests.share == pytest.approx(kept / (kept + 1.0))


def test_just_half_of_the_time_is_not_most_of_it():
    rests = RodRests()
    rests._stood, rests._passed = 0.5, 1.0
    assert not rests.sticks
    rests._stood = math.nextafter(0.5, 1.0)
    assert rests.sticks
