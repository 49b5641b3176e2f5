"""Where a search begins, and that it ends with the best of its parts on the whole ensemble."""

from types import SimpleNamespace

import pytest

from controllers.base import Tunable
from rig.hal.bench import Trial
from rig.hal.closed_loop import SENSITIVITY, ClosedLoop
from rig.tuning.candidate import cost_of
from rig.tuning.gains import gains_at, place_of
from rig.tuning.score import LOST, STOPPED, UNSTABLE
from rig.tuning.search import FIRST_LOOK, GENERATION, LAST_LOOK, GainSearch, trials_of
from rig.tuning.workbench import Request

STABLE = ClosedLoop(True, 50.0, 1.0, 0.01, 1.4)
PLANTS = 9
REQUEST = Request("rig", "law", None, (), None, 0)


class Bench:
    """Gains are worth the more the greater they are; one plant stops the rig above a bound."""

    tunables = (Tunable("a", 1.0, 10.0), Tunable("b", 1.0, 10.0))
    bears = 10.0

    def __init__(self):
        self.settings = SimpleNamespace(a=2.0, b=2.05)
        numbers = list(range(PLANTS))
        self.ensemble = SimpleNamespace(
            corners=lambda: numbers, first=lambda: (0, 1), near=lambda: [0, 1], nominal=0,
            other_units=lambda members: [10 + member for member in members],
        )  # fmt: skip

    def margins(self, gains, members):
        return [STABLE for _ in members]

    def measured(self, gains, members):
        return None

    def trial(self, gains, member, *, coarse):
        stopped = member == PLANTS - 1 and gains["a"] > self.bears
        # The search takes the plants with the greatest errors in: this one hides.
        error = (1e-5 if member == PLANTS - 1 else 1e-3) / gains["a"]
        return Trial({"slow": error}, 0.0, 0.0, 1.2 if stopped else 0.1, 1.0)


def searched(bench, folder):
    """Return what was found, and how many plants each candidate had."""
    search = GainSearch(bench, REQUEST, folder, 1, 6)
    had = []

    def judge(places, members):
        had.extend(len(members) for _ in places)
        gains = [gains_at(bench.tunables, place) for place in places]
        return [*zip([cost_of(bench, one, members) for one in gains], places, strict=True)]

    found = search._go(judge, SimpleNamespace(say=lambda _: None))
    return found, had


def test_the_best_of_all_parts_have_every_plant(tmp_path):
    found, had = searched(Bench(), tmp_path)
    assert found.gains["a"] == pytest.approx(10.0, rel=0.1)
    assert found.members == tuple(range(PLANTS))
    few = len(had) - had.count(PLANTS)
    assert (FIRST_LOOK + 6) * GENERATION < few <= trials_of(6, len(Bench.tunables))
    assert 1 <= had.count(PLANTS) <= LAST_LOOK


def test_gains_that_a_plant_stops_give_way_to_those_of_an_earlier_part(tmp_path):
    bench = Bench()
    greedy, _ = searched(bench, tmp_path)
    bench.bears = 0.97 * greedy.gains["a"]
    found, _ = searched(bench, tmp_path)
    assert found.gains["a"] <= bench.bears < greedy.gains["a"]


def test_a_search_begins_beside_the_gains_in_force_where_every_plant_has_margin(tmp_path):
    """Gains of a rig much like this one may lack no more than a little of it."""
    bench = Bench()
    margins = bench.margins
    here = place_of(bench.tunables, bench.settings)

    def lacking(gains, members):
        near = max(1.4, 10.0 * (gains["b"] - 1.85))  # in force: 2.05
        return [margin._replace(sensitivity=near) for margin in margins(gains, members)]

    bench.margins = lacking
    search = GainSearch(bench, REQUEST, tmp_path, 1, 6)
    assert search._nearness(here) > SENSITIVITY
    places = search._robust_places(here)
    assert len(places) == GENERATION
    assert all(search._nearness(place) <= SENSITIVITY for place in places)
    assert max(abs(x - y) for place in places for x, y in zip(place, here, strict=True)) < 0.3


def test_only_where_all_plants_are_asked_for_each_costs_that_stops():
    bench = Bench()
    bench.bears = 5.0
    few, everywhere = (0, PLANTS - 1), range(PLANTS)
    stopped, going = {"a": 6.0, "b": 1.0}, {"a": 4.0, "b": 1.0}
    assert cost_of(bench, stopped, few) - cost_of(bench, going, few) < STOPPED
    assert STOPPED < cost_of(bench, stopped, everywhere) - cost_of(bench, going, everywhere) < 3.0


def test_a_margin_is_not_given_for_a_plant_that_stops():
    bench = Bench()
    bench.bears = 5.0
    kept = cost_of(bench, {"a": 6.0, "b": 1.0}, range(PLANTS))
    bench.margins = lambda gains, members: [STABLE._replace(sensitivity=1.9) for _ in members]
    assert kept < cost_of(bench, {"a": 4.0, "b": 1.0}, range(PLANTS))


def test_margins_that_are_measured_have_the_word_and_on_the_plants_nearest_to_instability():
    bench, shaken = Bench(), []
    near = {0: 1.4, 1: 1.65}
    bench.margins = lambda gains, members: [STABLE._replace(sensitivity=near[m]) for m in members]
    gains, cost = {"a": 4.0, "b": 1.0}, {}

    def measured(gains, members):
        shaken.extend(members)
        return [STABLE._replace(sensitivity=found) for _ in members]

    cost["linear"] = cost_of(bench, gains, (0, 1))
    bench.measured = measured
    for found in (1.6, 2.0):
        cost[found] = cost_of(bench, gains, (0, 1))
    assert cost["linear"] == cost[1.6] < cost[2.0]
    assert shaken[:2] == [11, 10]


def test_gains_that_hardware_would_be_refused_with_are_behind_those_that_lose_a_plant():
    bench = Bench()
    gains = {"a": 6.0, "b": 1.0}
    trial = bench.trial
    bench.trial = lambda *args, **how: trial(*args, **how)._replace(lasted=0.5)
    lost = cost_of(bench, gains, range(PLANTS))
    bench.margins = lambda gains, members: [STABLE._replace(sensitivity=2.1) for _ in members]
    assert LOST < lost < cost_of(bench, gains, (0, 1)) < UNSTABLE
