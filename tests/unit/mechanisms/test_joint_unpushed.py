"""A pair that moves though nothing pushes it any further."""

import numpy as np
import pytest

from rig.hal import LimitExceeded
from rig.mechanisms.joint.alarms.unpushed import UnpushedWatch
from rig.mechanisms.pneumatic.alarms.tracking import Shifted

MOST = 2.0**-8
STEP = 2.0**-6
CALM = 0.25


def rods(first=0.0, second=0.0):
    """Return rods of two pairs at places, m."""
    return (first, -second, -first, second)


def stand(watched, push, at, duration, start=0.0):
    """Let the pairs stand under a push; return when it is over."""
    for k in range(round(duration / STEP) + 1):
        watched.check(push, rods(*at), start + k * STEP)
    return start + duration


@pytest.mark.parametrize("pair", [0, 1])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_pair_that_nothing_pushes_may_move_as_far_as_the_bound(pair, side):
    push = (0.0, 20.0) if pair == 0 else (20.0, 0.0)
    drawn = np.random.default_rng(pair)
    place = [float(drawn.uniform(-0.01, 0.01)) for _ in range(2)]
    place[pair] = 0.25
    watched = UnpushedWatch(MOST)
    now = stand(watched, push, place, 0.5)
    place[1 - pair] += 0.1  # the one that is pushed harder goes where it likes
    place[pair] += side * MOST
    harder = (0.0, 20.1) if pair == 0 else (20.1, 0.0)
    watched.check(harder, rods(*place), now)
    place[pair] += side * 1e-9
    words = ("ch1, ch3", "ch4, ch2")[pair]
    with pytest.raises(Shifted, match=f"way of the pair {words} that nothing pushes is") as got:
        watched.check(harder, rods(*place), now)
    assert got.value.value == pytest.approx(side * (MOST + 1e-9), rel=1e-9)
    assert (got.value.lower, got.value.upper) == (-MOST, MOST)
    assert (got.value.rod, got.value.ran) == ((0, 3)[pair], False)


@pytest.mark.parametrize("pair", [0, 1])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_pair_that_is_pushed_evenly_may_slide_until_it_stands(pair, side):
    push = (-8.0, 0.0) if pair == 0 else (0.0, -8.0)
    watched, now, place = UnpushedWatch(MOST), 0.0, [0.0, 0.0]

    def go(way, cycles):
        nonlocal now
        for _ in range(cycles):
            place[pair] += side * way
            watched.check(push, rods(*place), now)
            now += STEP

    go(0.5e-4, 100)  # slides for long, and by more than the bound
    go(0.0, 4)
    go(MOST, 1)  # not yet at rest for long enough
    go(0.0, round(CALM / STEP) + 1)
    go(-MOST, 1)
    with pytest.raises(Shifted, match="nothing pushes any further") as got:
        go(-1e-6, 1)
    assert got.value.rod == (0, 3)[pair]


def test_what_creeps_under_an_even_push_has_come_to_rest():
    watched, push = UnpushedWatch(MOST), (0.0, 8.0)
    watched.check(push, rods(0.0, 0.0), 0.0)
    watched.check(push, rods(0.0, 0.5e-3), CALM)  # no farther than what stands
    watched.check(push, rods(0.0, 0.5e-3 + MOST), CALM + STEP)
    with pytest.raises(Shifted):
        watched.check(push, rods(0.0, 0.501e-3 + MOST), CALM + 2 * STEP)
    slides = UnpushedWatch(MOST)
    slides.check(push, rods(0.0, 0.0), 0.0)
    slides.check(push, rods(0.0, 0.501e-3), CALM)
    slides.check(push, rods(0.0, 1.0), CALM + STEP)


def test_what_was_pushed_comes_to_rest_first():
    watched = UnpushedWatch(MOST)
    now = stand(watched, (20.0, 0.0), (0.0, 0.0), 1.0)
    for k in range(round(CALM / STEP)):
        watched.check((0.0, 20.0), rods(k * MOST), now + k * STEP)
    watched.check((0.0, 20.0), rods(0.125), now + CALM)
    with pytest.raises(LimitExceeded):
        watched.check((0.0, 20.0), rods(0.125 + 1.5 * MOST), now + CALM + STEP)


def test_a_pair_that_is_pushed_again_or_led_is_not_watched():
    push = (0.0, 20.0)
    for between in ("push", "restart"):
        watched = UnpushedWatch(MOST)
        now = stand(watched, push, (0.0, 0.0), 0.5)
        if between == "push":
            watched.check((1e-3, 0.0), rods(0.5), now)
        else:
            watched.restart()
        stand(watched, push, (0.5, 0.0), 0.5, now)
