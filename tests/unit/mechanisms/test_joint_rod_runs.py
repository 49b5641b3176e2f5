"""Which of some rods gained most for its pull when the last run began."""

import numpy as np
import pytest
from joint_fakes import BASE

from rig.mechanisms.joint.alarms.runs import RodRuns

STEP = 2.0**-10
COUNT = 2.0**-16
"""Of the encoder, m: what is added up stays exact."""
IDLE = 55e3
"""Pa, of a chamber that does not move its rod yet."""


def runs_of(ways, times=None):
    """Return what was told of rods 1 and 3 in each cycle, by their ways in counts."""
    runs = RodRuns(IDLE)
    rods, now = np.zeros(4), 0.0
    runs.follow(tuple(rods), now)
    for cycle, way in enumerate(ways):
        rods[[0, 2]] += np.array(way) * COUNT
        now += STEP if times is None else times[cycle]
        runs.follow(tuple(rods), now)
    return runs


def leader(ways, times, pulls):
    """Return 0 or 1, or None, from the ways of two rods (m) in each cycle (s), and their pulls."""
    quick = np.flatnonzero(ways.max(axis=1) > 0.1 * times)
    if not len(quick):
        return None
    slow = np.flatnonzero(ways[: quick[-1]].max(axis=1) <= 0.1 * times[: quick[-1]])
    began = slow[-1] + 1 if len(slow) else 0
    before = max(began - 2, 0)
    usual = ways[before] if began else np.zeros(2)
    gone = np.sum(ways[before : began + 3] - usual, axis=0)
    gains = gone / np.maximum(pulls, 1e3)
    first = int(np.argmax(gains))
    clear = gains[first] > 1.5 * max(gains[1 - first], 0.0)
    return first if clear and gone[first] > 0.25e-3 else None


@pytest.mark.parametrize("seed", range(6))
def test_the_first_cycles_of_the_last_run_say_who_leads(seed):
    """Drawn ways around the 0.1 m/s at which a run begins, 6.4 counts a cycle; short runs too."""
    rng = np.random.default_rng(seed)
    led = []
    for _ in range(150):
        count = int(rng.integers(1, 12))
        ways = rng.integers(rng.choice([-4, 5]), 9, (count, 2))
        pressures = rng.choice([40e3, 55.5e3, 56e3, 58e3, 60e3], 4)
        times = rng.choice([1.0, 1.0, 2.0], count) * STEP  # a cycle is lost now and then
        wanted = leader(ways * COUNT, times, pressures[[0, 2]] - IDLE)
        runs = runs_of(ways, times)
        assert runs.leader((0, 2), tuple(pressures)) == (None if wanted is None else 2 * wanted)
        assert runs.leader((2, 0), tuple(pressures)) == (None if wanted is None else 2 * wanted)
        led.append(wanted)
    assert {0, 1, None} <= set(led)


@pytest.mark.parametrize(("way", "clear"), [(31, True), (30, False)])
@pytest.mark.parametrize("among", [(0, 2), (3, 2, 1, 0)])
def test_who_leads_gained_half_as_much_again(way, clear, among):
    runs = runs_of([(0, 0), (0, 0), (way, 20), (0, 0)])
    assert runs.leader(among, (IDLE + 2.0**12,) * 4) == (0 if clear else None)


@pytest.mark.parametrize(("pressure", "clear"), [(BASE, True), (IDLE + 2.1 * (BASE - IDLE), False)])
def test_more_pressure_is_no_lead(pressure, clear):
    runs = runs_of([(0, 0), (0, 0), (60, 20)])
    assert runs.leader((0, 2), (pressure, BASE, BASE, BASE)) == (0 if clear else None)


@pytest.mark.parametrize(("way", "clear"), [(17, True), (16, False)])
def test_who_leads_went_a_quarter_of_a_millimetre(way, clear):
    """16.4 counts of the encoder."""
    runs = runs_of([(0, 0), (0, 0), (way, 0), (0, 0)])
    assert runs.leader((0, 2), (BASE,) * 4) == (0 if clear else None)


def test_a_run_that_is_over_counts_and_one_before_it_does_not():
    runs = runs_of([(0, 0), (0, 0), (0, 90), (0, 0), (0, 0), (40, 0), (0, 0), (0, 0)])
    assert runs.leader((0, 2), (BASE,) * 4) == 0


@pytest.mark.parametrize(("cycles", "found"), [(511, 0), (512, None)])
def test_so_many_cycles_are_remembered(cycles, found):
    """The way of the first one that is remembered has no beginning."""
    runs = runs_of([(40, 0), *[(0, 0)] * (cycles - 1)])
    assert runs.leader((0, 2), (BASE,) * 4) == found


def test_where_nothing_runs_nobody_leads():
    assert RodRuns(IDLE).leader((0, 2), (BASE,) * 4) is None
    assert runs_of([(5, 0)] * 40).leader((0, 2), (BASE,) * 4) is None
