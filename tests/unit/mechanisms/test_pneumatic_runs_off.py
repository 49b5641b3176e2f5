"""A rod has run off its reference if it is there by its own motion, and nothing has driven it."""

import pytest

from rig.mechanisms.pneumatic.alarms.runs_off import RunsOff

MOST = 2.0**-6
NEAR = 0.5 * MOST


def by_itself(k, error):
    return False


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_twice_as_far_as_what_is_near_is_a_run(side):
    runs = RunsOff(2, MOST)
    assert runs.has_run(1, side * NEAR, 0.25 + side * NEAR, by_itself) is False
    beyond = NEAR + 2.0**-10
    assert runs.has_run(1, side * beyond, 0.25 + side * beyond, by_itself) is False
    assert runs.has_run(1, side * MOST, 0.25 + side * MOST, by_itself) is False
    farther = MOST + 2.0**-10
    assert runs.has_run(1, side * farther, 0.25 + side * farther, by_itself) is True
    assert runs.has_run(0, side * farther, 0.25, by_itself) is False, "it was never near"


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_only_its_own_way_counts_from_where_it_was_last_near(side):
    def is_run(way):
        runs = RunsOff(1, MOST)
        runs.has_run(0, 0.0, 0.25 - side * NEAR, by_itself)
        runs.has_run(0, side * NEAR, 0.25, by_itself)  # at the very bound, it is near yet
        return runs.has_run(0, side * 2.0 * MOST, 0.25 + side * way, by_itself)

    assert is_run(NEAR) is False
    assert is_run(NEAR + 2.0**-20) is True
    assert is_run(-MOST) is False, "it has come back, and its reference has gone on"


def test_what_is_driven_off_is_asked_for_once_until_it_is_near_again():
    runs, asked = RunsOff(1, MOST), []

    def driven(k, error):
        asked.append((k, error))
        return True

    for error in (0.0, 2.0 * MOST, 3.0 * MOST):
        assert runs.has_run(0, error, error, driven) is False
    assert asked == [(0, 2.0 * MOST)]
    assert runs.has_run(0, 4.0 * MOST, 4.0 * MOST, by_itself) is False
    runs.has_run(0, 0.0, 0.0, by_itself)
    assert runs.has_run(0, 2.0 * MOST, 2.0 * MOST, by_itself) is True
