"""Where a search begins, and that it ends with the best of its parts on the whole ensemble."""

from types import SimpleNamespace

import numpy as np
import pytest

from controllers.base import Tunable
from rig.hal.bench import Trial
from rig.hal.closed_loop import SENSITIVITY, ClosedLoop
from rig.tuning.candidate import cost_of
from rig.tuning.ensemble import DRAWN, Plants
from rig.tuning.gains import gains_at, place_of
from rig.tuning.score import HUNTING, LOST, STOPPED, UNSTABLE
from rig.tuning.search import FIRST_LOOK, GENERATION, LAST_LOOK, GainSearch, trials_of
from rig.tuning.workbench import Request

STABLE = ClosedLoop(True, 50.0, 1.0, 0.01, 1.4)
PLANTS = 12
EVERYWHERE = Plants(tuple(range(PLANTS)))
QUIET = SimpleNamespace(say=lambda _: None)
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
            drawn=lambda number: number,
        )  # fmt: skip

    def margins(self, gains, members):
        return [STABLE for _ in members]

    def measured(self, gains, members):
        return None

    def shake(self, gains, part):
        numbers = range(part * DRAWN, (part + 1) * DRAWN)
        loops = self.measured(gains, numbers) or ()
        return {number: loop.sensitivity for number, loop in zip(numbers, loops, strict=False)}

    def trial(self, gains, member, *, coarse):
        stopped = member == PLANTS - 1 and gains["a"] > self.bears
        # The search takes the plants with the greatest errors in: this one hides.
        error = (1e-5 if member == PLANTS - 1 else 1e-3) / gains["a"]
        return Trial({"slow": error}, 0.0, 0.0, 1.2 if stopped else 0.1, 1.0)


class Alone:
    """What `Jury` says, in this process; counts the corners that each candidate had."""

    def __init__(self, bench):
        self.bench, self.had = bench, []

    def __call__(self, places, plants):
        self.had.extend(len(plants.corners) for _ in places)
        gains = [gains_at(self.bench.tunables, place) for place in places]
        return [*zip([cost_of(self.bench, one, plants) for one in gains], places, strict=True)]

    def shake(self, place, part):
        return self.bench.shake(gains_at(self.bench.tunables, place), part)


def searched(bench, folder):
    """Return what was found, and how many plants each candidate had."""
    alone = Alone(bench)
    return GainSearch(bench, REQUEST, folder, 1, 6)._go(alone, QUIET), alone.had


def test_the_best_of_all_parts_have_every_plant(tmp_path):
    found, had = searched(Bench(), tmp_path)
    assert found.gains["a"] == pytest.approx(10.0, rel=0.1)
    assert found.plants == Plants(tuple(range(PLANTS)))
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
    few = Plants((0, PLANTS - 1))
    stopped, going = {"a": 6.0, "b": 1.0}, {"a": 4.0, "b": 1.0}
    assert cost_of(bench, stopped, few) - cost_of(bench, going, few) < STOPPED
    assert STOPPED < cost_of(bench, stopped, EVERYWHERE) - cost_of(bench, going, EVERYWHERE) < 3.0


def test_where_all_plants_are_asked_for_each_that_hunts_costs_as_much_as_one_that_stops():
    """A hold that hunts by a millimetre on one plant of 28 was a seventh of what it cost before."""
    bench, gains, trial = Bench(), {"a": 4.0, "b": 1.0}, Bench().trial

    def hunting(size):
        def run(gains, member, *, coarse):
            hunts = size if member == PLANTS - 1 else 0.0
            return trial(gains, member, coarse=coarse)._replace(hunting=hunts)

        bench.trial = run
        return cost_of(bench, gains, EVERYWHERE), cost_of(bench, gains, Plants((0, PLANTS - 1)))

    (little, few), (much, more) = hunting(0.99 * HUNTING), hunting(1.01 * HUNTING)
    assert little + STOPPED < much < little + 1.1 * STOPPED
    assert few < more < few + 0.1


def test_all_plants_are_run_as_the_verdict_runs_them_and_few_of_them_coarsely():
    bench, ways = Bench(), []
    trial = bench.trial
    bench.trial = lambda *of, coarse: ways.append(coarse) or trial(*of, coarse=coarse)
    for plants in (EVERYWHERE, Plants((0, 1))):
        cost_of(bench, {"a": 4.0, "b": 1.0}, plants)
    assert ways == [False] * PLANTS + [True] * 2


def test_a_margin_is_not_given_for_a_plant_that_stops():
    bench = Bench()
    bench.bears = 5.0
    kept = cost_of(bench, {"a": 6.0, "b": 1.0}, EVERYWHERE)
    bench.margins = lambda gains, members: [STABLE._replace(sensitivity=1.9) for _ in members]
    assert kept < cost_of(bench, {"a": 4.0, "b": 1.0}, EVERYWHERE)


def test_margins_that_are_measured_have_the_word_on_the_drawn_plants_that_are_asked_for():
    bench, shaken = Bench(), []
    bench.margins = lambda gains, members: [STABLE._replace(sensitivity=1.65) for _ in members]
    gains, cost, plants = {"a": 4.0, "b": 1.0}, {}, Plants((0, 1), (7, 3))

    def measured(gains, members):
        shaken.extend(members)
        return [STABLE._replace(sensitivity=found) for _ in members]

    cost["linear"] = cost_of(bench, gains, plants)
    bench.measured = measured
    for found in (1.6, 2.0):
        cost[found] = cost_of(bench, gains, plants)
    assert cost["linear"] == cost[1.6] < cost[2.0]
    assert shaken[:2] == [7, 3]


def test_a_plant_that_catches_while_it_is_shaken_asks_for_no_softer_gains():
    bench, gains = Bench(), {"a": 4.0, "b": 1.0}
    found = {number: 1.5 + 0.01 * number for number in range(12)}
    bench.measured = lambda gains, members: [STABLE._replace(sensitivity=found[m]) for m in members]
    plants = Plants((0, 1), tuple(range(12)), spared=2)
    cost = cost_of(bench, gains, plants)
    found |= {5: 9.0, 7: float("inf")}
    assert cost_of(bench, gains, plants) == cost
    found |= {6: 1.9}
    assert cost_of(bench, gains, plants) > cost


@pytest.mark.parametrize(("bears", "share"), [(9.0, 1.0), (5.9, 0.8), (3.9, 0.6), (2.5, 0.4)])
def test_the_search_goes_back_towards_the_gains_in_force_as_far_as_drawn_plants_ask(
    bears, share, tmp_path
):
    """Two of 200 plants have no margin: so many are spared. Beyond some gain there is a third."""
    bench, seen = Bench(), set()

    def measured(gains, members):
        seen.update(members)
        missing = 2 if gains["a"] <= bears else 3
        near = [9.0] * missing + [1.6] * (len(members) - missing)
        return [STABLE._replace(sensitivity=one) for one in near]

    bench.measured = measured
    here, best = (place_of(bench.tunables, SimpleNamespace(a=a, b=2.0)) for a in (1.0, 8.9))
    search = GainSearch(bench, REQUEST, tmp_path, 1, 6)
    seen_before = EVERYWHERE._replace(drawn=(205, 403, 610))
    found = search._way_back(Alone(bench), here, best, seen_before, QUIET)
    assert found == [old + share * (new - old) for old, new in zip(here, best, strict=True)]
    assert seen == set(range(4 * DRAWN, 5 * DRAWN))


def test_those_of_two_hundred_plants_that_gains_bear_least_are_shaken_others_for_each_part(
    tmp_path,
):
    """Plants on which gains were found say too much good of them: the verdict has others."""
    bench, spread = Bench(), np.random.default_rng(2119).permutation(7 * DRAWN)

    def measured(gains, members):
        return [STABLE._replace(sensitivity=1.3 + 1e-4 * spread[m]) for m in members]

    bench.measured = measured
    found, _ = searched(bench, tmp_path)
    worst = []
    for part, count in ((1, 6), (2, 3), (3, 3), (4, 3), (5, 3)):
        numbers = range(part * DRAWN, (part + 1) * DRAWN)
        worst += sorted(numbers, key=lambda number: -spread[number])[:count]
    assert list(found.plants.drawn) == worst


def test_gains_that_hardware_would_be_refused_with_are_behind_those_that_lose_a_plant():
    bench = Bench()
    gains = {"a": 6.0, "b": 1.0}
    trial = bench.trial
    bench.trial = lambda *args, **how: trial(*args, **how)._replace(lasted=0.5)
    lost = cost_of(bench, gains, EVERYWHERE)
    bench.margins = lambda gains, members: [STABLE._replace(sensitivity=2.1) for _ in members]
    assert LOST < lost < cost_of(bench, gains, Plants((0, 1))) < UNSTABLE
