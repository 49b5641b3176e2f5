"""Opposite encoders that are swapped: work against the pull, over its way and beyond its share."""

import math

import pytest
from joint_fakes import CHANNELS, ENCODERS

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.alarms.settings import SwappedAlarm
from rig.mechanisms.pneumatic.alarms.work import WorkWatch

WAY = 2.0**-10
STEP = WAY / 8
AREA, COULOMB = 2.0, 16.0
BOUND = 0.25 * COULOMB
"""Mean pull against the motion, N, from which on it is a fault."""
PAIRS = {"e1 and e3": ((0, 2), "ch1 and ch3"), "e2 and e4": ((3, 1), "ch2 and ch4")}


class Bench:
    """A pair that goes on by steps under a pull."""

    def __init__(self, pair=(0, 2), coulomb=COULOMB, explain=lambda: None):
        self.watch = WorkWatch(
            SwappedAlarm(WAY, 0.25),
            AREA,
            coulomb,
            ENCODERS,
            CHANNELS,
            tuple(pair for pair, _ in PAIRS.values()),
        )
        self.pair = pair
        self.place = 0.0
        self.explain = explain
        self.step(0.0, 0.0)

    def step(self, way, pull):
        """Move the pair by a way, m, while it is pulled along, N."""
        agonist, antagonist = self.pair
        self.place += way
        rods, pressures = [0.0] * 4, [1e5] * 4
        rods[agonist], rods[antagonist] = self.place, -self.place
        pressures[agonist] += pull / AREA
        self.watch.check(tuple(rods), tuple(pressures), self.explain)

    def steps(self, count, pull, way=STEP):
        for _ in range(count):
            self.step(way, pull)


@pytest.mark.parametrize("way", [STEP, -STEP])
@pytest.mark.parametrize(("names", "what"), PAIRS.items())
def test_a_pair_that_moves_against_its_pull_is_named(names, what, way):
    pair, tubes = what
    against = -math.copysign(BOUND, way)
    bench = Bench(pair)
    bench.steps(20, against, way)  # not more than the share
    bench = Bench(pair)
    bench.steps(7, 1.001 * against, way)  # not far enough
    with pytest.raises(SafetyError) as caught:
        bench.step(way, 1.001 * against)
    assert str(caught.value) == (
        f"{names} are swapped, or the tubes of {tubes}, or one of these tubes is off: the rods "
        f"move against their pull, or are pushed [work -3.9 mJ over 0.98 mm, at least -3.9 mJ]"
    )


def test_the_pull_is_that_of_the_agonist_less_that_of_the_antagonist():
    bench = Bench()
    for k in range(1, 8):
        bench.watch.check((k * STEP, 0.0, -k * STEP, 0.0), (0.0, 0.0, 3.0, 0.0), bench.explain)
    with pytest.raises(SafetyError, match="e1 and e3"):
        bench.watch.check((8 * STEP, 0.0, -8 * STEP, 0.0), (0.0, 0.0, 3.0, 0.0), bench.explain)


def test_a_pair_is_where_half_the_difference_of_its_rods_is():
    bench = Bench()
    for k in range(1, 16):  # one rod stands: half the way
        bench.watch.check((k * STEP, 0.0, 0.0, 0.0), (0.0, 0.0, 3.0, 0.0), bench.explain)
    with pytest.raises(SafetyError, match="e1 and e3"):
        bench.watch.check((16 * STEP, 0.0, 0.0, 0.0), (0.0, 0.0, 3.0, 0.0), bench.explain)


def test_a_pair_that_has_passed_is_not_looked_at_again():
    bench = Bench()
    bench.steps(8, BOUND)  # as much as the share and not more
    with pytest.raises(SafetyError):
        bench.steps(8, -2.0 * BOUND)
    bench = Bench()
    bench.steps(8, 1.001 * BOUND)
    bench.steps(20, -2.0 * BOUND)
    # The other pair has not passed yet.
    bench.pair, bench.place = (3, 1), 0.0
    with pytest.raises(SafetyError, match="e2 and e4"):
        bench.steps(9, -2.0 * BOUND)


def test_work_is_added_over_the_last_part_of_the_way_alone():
    bench = Bench()
    bench.steps(30, 0.5 * BOUND)
    bench.steps(6, -1.5 * BOUND)  # of the last eight: (2 * 0.5 - 6 * 1.5) / 8 of the bound is -1
    with pytest.raises(SafetyError, match=r"work -4\.9 mJ over 0\.98 mm"):
        bench.step(STEP, -1.5 * BOUND)


def test_the_window_keeps_what_it_needs_for_the_whole_way():
    """Steps of 0.3 of the way: four are enough, and three are not."""
    bench = Bench()
    bench.steps(20, -0.999 * BOUND, 0.3 * WAY)
    bench = Bench()
    bench.steps(3, -2.0 * BOUND, 0.3 * WAY)
    with pytest.raises(SafetyError, match=r"over 1\.17 mm"):
        bench.steps(1, -2.0 * BOUND, 0.3 * WAY)
    bench = Bench()
    with pytest.raises(SafetyError):
        bench.steps(4, -1.001 * BOUND, 0.3 * WAY)


def test_noise_of_encoders_is_no_motion():
    least = 20e-6
    bench = Bench()
    for _ in range(200):
        bench.step(math.nextafter(least, 0.0), -3.0 * BOUND)
        bench.step(-math.nextafter(least, 0.0), 3.0 * BOUND)
    with pytest.raises(SafetyError):
        for _ in range(200):
            bench.step(least, -3.0 * BOUND)
            bench.place = 0.0
            bench.step(0.0, 3.0 * BOUND)


def test_slow_motion_is_added_up_nevertheless():
    bench = Bench()
    with pytest.raises(SafetyError, match=r"over 0\.9[89] mm|over 1\.0\d mm"):
        bench.steps(500, -2.0 * BOUND, 3e-6)


def test_a_swap_that_explains_it_comes_first():
    bench = Bench(explain=lambda: "e1 and e2 are swapped")
    with pytest.raises(SafetyError, match=r"^e1 and e2 are swapped: the rods move against"):
        bench.steps(8, -2.0 * BOUND)


def test_without_friction_nothing_can_be_told():
    bench = Bench(coulomb=0.0)
    bench.steps(50, -BOUND)


def test_with_little_friction_it_can_be_told_as_well():
    bench = Bench(coulomb=2.0)
    with pytest.raises(SafetyError, match="e1 and e3"):
        bench.steps(8, -1.0)
