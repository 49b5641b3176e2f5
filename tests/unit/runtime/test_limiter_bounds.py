"""The choke point of commands on its bounds, in numbers that floating point holds exactly."""

import math

import pytest

from rig.hal import LimitExceeded
from rig.runtime.limits import VectorLimiter

LOWER, UPPER, STEP, PERIOD = -256.0, 512.0, 16.0, 2.0**-10
TINY = 2.0**-30


def limiter(start=None):
    made = VectorLimiter("pressure", LOWER, UPPER, STEP / PERIOD, PERIOD, "Pa")
    if start is not None:
        made.reset(start)
    return made


@pytest.mark.parametrize(("bound", "way"), [(LOWER, -1.0), (UPPER, 1.0)])
def test_the_range_is_permitted_and_nothing_beyond(bound, way):
    made = limiter((bound, bound))
    assert made.limit((bound, bound)) == (bound, bound)
    assert (made.range_hits, made.rate_hits) == (0, 0)
    assert made.limit((bound + way * TINY, bound)) == (bound, bound)
    assert (made.range_hits, made.rate_hits) == (1, 0)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_step_is_permitted_and_nothing_beyond(way):
    made = limiter((0.0, 0.0))
    assert made.limit((way * STEP, 0.0)) == (way * STEP, 0.0)
    assert made.rate_hits == 0
    assert made.limit((way * (2.0 * STEP + TINY), 0.0)) == (way * 2.0 * STEP, 0.0)
    assert (made.range_hits, made.rate_hits) == (0, 1)


def test_each_element_is_limited_by_itself_and_counted():
    made = limiter((0.0, 100.0, 200.0))
    assert made.limit((600.0, 90.0, 100.0)) == (STEP, 90.0, 200.0 - STEP)
    assert (made.range_hits, made.rate_hits) == (1, 2)


def test_the_rate_counts_from_what_was_applied():
    made = limiter((0.0,))
    assert [made.limit((100.0,))[0] for _ in range(8)] == [16, 32, 48, 64, 80, 96, 100, 100]


def test_a_start_outside_the_range_is_taken_for_its_end():
    made = limiter((UPPER + 100.0, LOWER - 100.0))
    assert made.limit((0.0, 0.0)) == (UPPER - STEP, LOWER + STEP)


def test_without_a_start_the_first_command_is_one():
    made = limiter()
    assert made.limit((500.0, UPPER + 1.0)) == (500.0, UPPER)
    assert made.limit((0.0, 0.0)) == (500.0 - STEP, UPPER - STEP)


@pytest.mark.parametrize("count", [1, 3])
def test_a_command_of_another_length_is_a_bug(count):
    with pytest.raises(ValueError, match=f"pressure: {count} commands after 2"):
        limiter((0.0, 0.0)).limit((0.0,) * count)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_has_no_nearest_permitted_one(bad):
    made = limiter((0.0, 0.0))
    with pytest.raises(LimitExceeded) as caught:
        made.limit((0.0, bad))
    error = caught.value
    assert (error.quantity, error.lower, error.upper, error.unit) == (
        "commanded pressure",
        LOWER,
        UPPER,
        "Pa",
    )
    assert made.range_hits == 0
