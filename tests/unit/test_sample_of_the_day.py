"""Slow cases take turns: those of a day are few, and none is left out for ever."""

from types import SimpleNamespace

import pytest
from sample_of_the_day import having_their_turn, set_the_others_apart


@pytest.mark.parametrize(("count", "most"), [(1, 1), (7, 3), (29, 4), (40, 40), (5, 8)])
def test_every_case_has_its_turn_soon(count, most):
    cases = [f"case {k}" for k in range(count)]
    days = [having_their_turn(cases, most, day, "test") for day in range(739_000, 739_100)]
    assert {len(chosen) for chosen in days} == {min(most, count)}
    soon = -(-count // most)
    for first in range(100 - soon):
        assert set().union(*days[first : first + soon]) == set(cases)


def test_two_tests_of_the_same_cases_go_round_in_another_order():
    cases = list(range(100))
    assert having_their_turn(cases, 5, 1, "one") != having_their_turn(cases, 5, 1, "other")


class Item:
    """As much of pytest's as is looked at."""

    def __init__(self, function, *markers, **params):
        self.nodeid = f"tests/file.py::{function}[{'-'.join(map(str, params.values()))}]"
        self.callspec = SimpleNamespace(params=params)
        self.markers = list(markers)

    def get_closest_marker(self, name):
        return next((marker for marker in self.markers if marker.name == name), None)

    def add_marker(self, marker):
        self.markers.append(marker.mark)

    @property
    def is_lengthy(self):
        return self.get_closest_marker("lengthy") is not None


SLOW = pytest.mark.slow.mark


def test_of_each_rig_as_many_have_their_turn():
    sampled = pytest.mark.sampled(2, each="rig").mark
    items = [Item("f", SLOW, sampled, rig=r, seed=s) for r in "ab" for s in range(7)]
    set_the_others_apart(items, 3)
    left = [item.callspec.params["rig"] for item in items if not item.is_lengthy]
    assert left == ["a", "a", "b", "b"]


def test_what_is_not_slow_or_not_sampled_stays_as_it_is():
    sampled = pytest.mark.sampled(1).mark
    items = [Item("f", sampled, seed=1), Item("f", SLOW, seed=2), Item("g", SLOW, sampled, seed=3)]
    set_the_others_apart(items, 0)
    assert not any(item.is_lengthy for item in items)


def test_what_is_always_lengthy_takes_nobodys_turn():
    sampled, lengthy = pytest.mark.sampled(1).mark, pytest.mark.lengthy.mark
    always = [Item("f", SLOW, sampled, lengthy, seed=s) for s in range(9)]
    items = [*always, *(Item("f", SLOW, sampled, seed=s) for s in range(10, 13))]
    for day in range(12):
        for item in items[9:]:
            item.markers = [marker for marker in item.markers if marker.name != "lengthy"]
        set_the_others_apart(items, day)
        assert sum(not item.is_lengthy for item in items) == 1


def test_what_is_lengthy_and_not_slow_is_a_mistake():
    items = [Item("f", pytest.mark.lengthy.mark, seed=1)]
    with pytest.raises(pytest.UsageError, match=r"f\[1\] is marked lengthy, and not slow"):
        set_the_others_apart(items, 0)


def test_functions_have_turns_of_their_own():
    sampled = pytest.mark.sampled(1).mark
    items = [Item(f, SLOW, sampled, seed=s) for f in "fg" for s in range(9)]
    set_the_others_apart(items, 5)
    left = [item.nodeid for item in items if not item.is_lengthy]
    assert [nodeid[len("tests/file.py::")] for nodeid in left] == ["f", "g"]
