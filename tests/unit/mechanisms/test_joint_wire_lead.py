"""Which of two opposite rods let go, and what three rods say of the fourth, in detail."""

import math

import numpy as np
import pytest
from joint_fakes import BASE, UPRIGHT, WireBench, off, rods_at

TILTED = rods_at(0.3, 0.4)


# Which of two opposite rods let go ---------------------------------------------------------


def first_to_run(ways, times, pulls):
    """Return 0 if the first rod of two let go, else 1, from their ways (m) in each cycle (s)."""
    quick = ways.max(axis=1) > 0.1 * times
    at_rest = np.flatnonzero(~quick)
    began = at_rest[-1] + 1 if len(at_rest) else 0
    if began == len(ways):
        return 0
    window = ways[max(began - 1, 0) : began + 3] - ways[max(began - 2, 0)]
    gains = window.sum(axis=0) / np.maximum(pulls, 1e3)
    return int(np.argmax(gains))


RUN_STEP = 2.0**-10
COUNT = 2.0**-16
"""Of the encoder, m: what is added up stays exact."""


def run_of(ways, times=None):
    """Return a watch that was told of rods 1 and 3 in each cycle, by their ways in counts."""
    watch = WireBench().watch
    rods, now = np.zeros(4), 0.0
    watch.follow(tuple(rods), now)
    for cycle, way in enumerate(ways):
        rods[[0, 2]] += np.array(way) * COUNT
        now += RUN_STEP if times is None else times[cycle]
        watch.follow(tuple(rods), now)
    return watch


@pytest.mark.parametrize("seed", range(6))
def test_the_first_cycles_of_a_run_say_who_let_go(seed):
    """Drawn ways around the 0.1 m/s at which a run begins, 6.4 counts a cycle; short runs too."""
    rng = np.random.default_rng(seed)
    for _ in range(150):
        count = int(rng.integers(1, 12))
        lowest = rng.choice([-4, 5])
        ways = rng.integers(lowest, 9, (count, 2))
        pressures = rng.choice([40e3, 55.5e3, 56e3, 58e3, 60e3], 4)
        times = rng.choice([1.0, 1.0, 2.0], count) * RUN_STEP  # a cycle is lost now and then
        watch = run_of(ways, times)
        pulls = pressures[[0, 2]] - 55e3
        for asked, k in ((0, 0), (1, 2)):
            turn = 1 - 2 * asked  # the asked one first
            led = first_to_run(ways[:, ::turn] * COUNT, times, pulls[::turn])
            assert watch._leader(k, UPRIGHT, tuple(pressures)) == (k, 2 - k)[led]


def test_of_two_that_gained_the_same_the_asked_one_let_go():
    watch = run_of([(0, 0), (1, 1), (9, 9), (12, 12)])
    assert [watch._leader(k, UPRIGHT, (BASE,) * 4) for k in (0, 2)] == [0, 2]


@pytest.mark.parametrize(
    ("tilt", "besides", "clear"),
    [(0.9, 0.0, True), (0.9, -1e-3, True), (0.9, -2e-3, False), (1.1, -3e-3, False)],
)
def test_what_is_off_tells_who_let_go_only_if_it_does_so_clearly(tilt, besides, clear):
    """One fits better by four, or by less than that: then it is the one that gained more."""
    wrong = off(off(rods_at(tilt, 0.8), 1, 6e-3), 2, besides)
    watch = run_of([(0, 0), (0, 0), (0, 9), (0, 12)])
    rests = [watch._without(wrong, k)[0] for k in (0, 2)]
    assert max(rests) > 1e-3
    assert (rests[0] < 0.25 * rests[1]) is clear
    assert rests[0] < 0.5 * rests[1]
    assert watch._leader(2, wrong, (BASE,) * 4) == (0 if clear else 2)


# What is looked at leaves no trace ---------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_what_was_looked_at_before_changes_nothing(seed):
    """To the last bit: a search that began elsewhere would end elsewhere."""
    rng = np.random.default_rng(seed)
    places = [off(rods_at(rng.uniform(0.1, 0.9), rng.uniform(0.0, 6.0)), 1, 1e-3) for _ in range(4)]
    fresh = [
        (WireBench().watch.axis_of(place), WireBench().watch._residual_of(place),
         WireBench().watch._without(place, 2))
        for place in places
    ]  # fmt: skip
    watch = WireBench().watch
    for ask in range(3):
        for place, before in zip(places, fresh, strict=True):
            asks = (watch.axis_of, watch._residual_of, lambda rods: watch._without(rods, 2))
            assert asks[ask](place) == before[ask]


def test_three_rods_have_their_pose_in_a_few_rounds(monkeypatch):
    watch = WireBench().watch
    solve, tried = watch._diagnosis.update, []
    monkeypatch.setattr(watch._diagnosis, "update", lambda rods: tried.append(rods) or solve(rods))
    watch._without(off(TILTED, 1, 2e-3), 0)
    assert 2 < len(tried) < 20


def test_the_rest_is_of_three_rods():
    """Also where the fourth has not come to rest."""
    watch = WireBench().watch
    solve, found = watch._diagnosis.update, []
    watch._diagnosis.update = lambda rods: found.append(solve(rods)) or found[-1]
    left, _ = watch._without(off(rods_at(0.79, 0.5 * math.pi), 1, 14e-3), 1)
    residuals = np.array(found[-1].residuals)
    assert abs(residuals[1]) > 1e-6
    assert left == pytest.approx(math.sqrt(0.5 * np.sum(np.delete(residuals, 1) ** 2)), rel=1e-12)


def test_the_ends_of_a_cylinder_and_the_speed_of_rest_belong_to_them():
    watch = WireBench().watch
    end = "the wire of ch1 is cut or has come off: its rod is at its end"
    for home, stroke, rod in ((1e-3, 0.06, 0.0), (2.0 - 1e-3, 2.0, 0.0)):
        watch._limits = watch._limits._replace(home=home, stroke=stroke)
        assert watch._explain_wire(0, 2e-3, rod, BASE) == end
    bench = WireBench(residual=math.inf)
    for rod in (0.0, 0.05 * bench.STEP):
        bench.check((rod, 0.0, 0.0, 0.0))
    assert "has slipped" in bench.watch._explain_wire(0, 2e-3, 0.0, BASE)
