"""A walk from gains that are nearly right ends where a bowl is deepest, whatever it looks like."""

import random

import pytest

from rig.tuning.walk import STEPS, TOGETHER, one_by_one, together, tried_by_walk


def walked(place, cost):
    """Return where a walk ends, and how many places it tried."""
    least, tries = cost(place), 0
    for step in STEPS:
        here = list(place)
        alone = [(cost(other), other) for other in one_by_one(here, step)]
        both = [(cost(other), other) for other in together(here, least, alone)]
        tries += len(alone) + len(both)
        least, place = min([(least, here), *alone, *both])
    return place, tries


@pytest.mark.parametrize("seed", range(6))
def test_what_single_gains_lack_is_found_at_once(seed):
    """Some gains are off by up to a step, and the rest are right."""
    chance = random.Random(seed)
    count = chance.randint(3, 20)
    right = [chance.uniform(0.2, 0.8) for _ in range(count)]
    off = chance.sample(range(count), chance.randint(1, min(count, TOGETHER)))
    begin = list(right)
    for number in off:
        begin[number] += chance.choice((-1, 1)) * chance.uniform(0.06, 0.14)

    def cost(place):
        return sum((a - b) ** 2 for a, b in zip(place, right, strict=True))

    end, tries = walked(begin, cost)
    assert tries <= tried_by_walk(count)
    for number in range(count):
        assert abs(end[number] - right[number]) <= 0.045
    assert cost(end) < 0.25 * cost(begin)


def test_where_nothing_helps_it_stays():
    place = [0.5, 0.5, 0.5]
    end, tries = walked(place, lambda other: sum((x - 0.5) ** 2 for x in other))
    assert end == place
    assert tries == 2 * 3 * len(STEPS)


def test_it_keeps_within_the_bounds_and_moves_one_gain_at_a_time():
    place = [0.0, 1.0, 0.97]
    tried = one_by_one(place, 0.1)
    assert all(0.0 <= share <= 1.0 for other in tried for share in other)
    assert all(sum(a != b for a, b in zip(place, other, strict=True)) <= 1 for other in tried)
    assert [0.0, 1.0, 1.0] in tried


def test_the_best_come_together_first():
    alone = [(3.0, [0.6, 0.5, 0.5]), (1.0, [0.5, 0.4, 0.5]), (2.0, [0.5, 0.5, 0.6]),
             (9.0, [0.4, 0.5, 0.5]), (1.5, [0.5, 0.6, 0.5])]  # fmt: skip
    found = together([0.5, 0.5, 0.5], 4.0, alone)
    assert found == [[0.5, 0.4, 0.6], [0.6, 0.4, 0.6]]
    assert together([0.5, 0.5, 0.5], 1.2, alone) == []
