"""A pair that is driven on by what its monitors do not show is found within milliseconds."""

import math

import numpy as np
import pytest
from cylinder_rods import Rods as PairRods
from joint_fakes import RESIDUAL, off, rods_at
from joint_rods import Rods as JointRods
from pneumatic_fakes import BASE
from test_pneumatic_pull_balance import FRICTION, MASS, PLAIN, balance, slide

from rig.hal import SafetyError
from rig.mechanisms.pneumatic.alarms.missing import Instant, UnseenPull

LEAST = 0.9 * PLAIN.coulomb
CYCLE = 2.0**-10
"""s: times are exact."""


def driven(missing, sign=1.0, speed=0.1, cycles=40, period=CYCLE):
    """Return a watch that has seen a pair glide evenly while so much is missing, N."""
    watch = UnseenPull(MASS, PLAIN)
    pull = 0.8 * PLAIN.coulomb - missing
    for k in range(cycles):
        watch.note(Instant(k * period, sign * speed * k * period, sign * pull))
    return watch


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_nine_tenths_of_the_friction_are_too_much(sign):
    assert driven(1.001 * LEAST, sign).lasts
    assert not driven(0.999 * LEAST, sign).lasts
    assert not driven(-2.0 * LEAST, sign).lasts, "it is braked"


@pytest.mark.parametrize("period", [CYCLE, 2.0 * CYCLE, 8.0 * CYCLE])
def test_it_is_found_once_it_has_lasted(period):
    """Half a millimetre at 0.1 m/s and 8 ms come first, then 3 ms."""
    found = next(k for k in range(40) if driven(20.0, cycles=k + 1, period=period).lasts)
    seen = next(k for k in range(40) if k * period >= 8e-3)
    assert found == next(k for k in range(40) if (k - seen) * period >= 3e-3)


def test_what_hardly_moves_is_not_driven():
    """Of the last 20 ms there are 21 cycles."""
    slowest = 0.5e-3 / (20.0 * CYCLE)
    assert driven(20.0, speed=1.001 * slowest).lasts
    assert not driven(20.0, speed=0.999 * slowest).lasts


def test_what_stops_begins_anew():
    watch, k = driven(20.0), 40
    assert watch.lasts

    def note(place, pull):
        nonlocal k
        watch.note(Instant(k * CYCLE, place, pull))
        k += 1

    for _ in range(25):
        note(4e-3, 0.0)
    assert not watch.lasts
    for passed in range(7):
        note(4.6e-3 + 3e-4 * passed, 0.0)
        assert watch.lasts is (passed >= 4), "3 ms are over three cycles"
    note(6.8e-3, 200.0)
    note(7.2e-3, 200.0)
    assert not watch.lasts, "its pressures do it"


def test_what_is_led_goes_less_than_a_millimetre_and_a_half():
    assert not UnseenPull(MASS, PLAIN).runs
    most = 1.5e-3 / (20.0 * CYCLE)
    assert driven(0.0, speed=1.001 * most).runs
    assert driven(0.0, sign=-1.0, speed=1.001 * most).runs
    assert not driven(0.0, speed=0.999 * most).runs


@pytest.mark.parametrize("seed", range(20))
def test_healthy_pairs_are_not_and_those_that_a_chamber_lets_go_are(seed):
    """With 0.7 to 1.5 of the friction, from rest or gliding; a chamber of 250 N that is empty."""
    drawn = np.random.default_rng([2, seed])
    sign = float(drawn.choice([-1.0, 1.0]))
    pull, scale = sign * drawn.uniform(12.0, 60.0), drawn.uniform(0.7, 1.5)
    start = sign * drawn.uniform(0.0, 0.3)
    for unseen, lasts in ((0.0, False), (sign * drawn.uniform(30.0, 45.0), True)):
        watch, found = UnseenPull(MASS, FRICTION), False
        shown = pull if not unseen else sign * drawn.uniform(0.0, 12.0)
        for instant in slide(shown, shown + unseen, scale, start, 1e-3):
            watch.note(instant)
            found |= watch.lasts
        assert found is lasts


def test_it_is_told_with_the_chamber_and_the_bound():
    watch = balance()
    for k in range(26):
        assert watch.explain_unseen() is None
        assert not watch.runs()
        way = 50e-6 * k
        watch.note(k * CYCLE, (way, 0.0, -way, 0.0), (0.0,) * 4)
    for k in range(26, 39):
        way = 200e-6 * (k - 26) + 1.3e-3
        watch.note(k * CYCLE, (way, 0.0, -way, 0.0), (0.0, 0.0, 50e3, 0.0))
    said = watch.explain_unseen()
    assert said is not None
    assert "the chamber of ch3 leaks behind its tube" in said
    assert said.endswith(
        " N are not those of the pressures; or its seals have far less friction than the profile "
        "says (`rig calibrate RIG friction`) [9 N for 3 ms, while it moves]"
    )
    assert watch.runs()
    assert not watch.runs(1)
    watch.restart()
    assert not watch.runs()
    assert watch.explain_unseen() is None


def test_a_pair_that_runs_is_stopped_while_its_rods_agree():
    def ran(lag):
        rods = PairRods(change=1e-3)
        rods.settle((2.0 * BASE, 2.0 * BASE))
        for k in range(1, 60):
            way = 60e-6 * k
            rods.cycle(way, -way + min(lag, way), (2.0 * BASE, 2.0 * BASE))

    with pytest.raises(SafetyError, match="the chamber of agonist leaks behind its tube"):
        ran(0.0)
    ran(0.6e-3)


def test_a_ring_that_runs_is_stopped_while_its_rods_agree():
    def ran(lag):
        rods = JointRods()
        for k in range(80):  # back to the middle: outwards it falls by itself
            behind = max(lag * (k > 0), 0.0)
            rods.check(off(rods_at(0.3 - 2e-3 * k, 0.4), 1, behind))

    with pytest.raises(SafetyError, match=r"the chamber of ch\d( or ch\d)? leaks behind its tube"):
        ran(0.0)
    ran(1.2 * RESIDUAL)


def at(watch, t, place, pull=0.0):
    watch.note(Instant(t, place, pull))
    return watch


def test_the_bounds_belong_to_it():
    """Nine tenths of the friction, half a millimetre, 8 ms and 3 ms are enough."""

    def lasts(missing=20.0, way=0.5e-3, then=-0.008, last=0.003):
        watch = UnseenPull(MASS, PLAIN)
        pull = 0.8 * PLAIN.coulomb - missing
        for t, share in ((then, 0.0), (0.0, 1.0), (last, 1.0)):
            at(watch, t, share * way, pull)
        return watch.lasts

    assert lasts()
    assert not lasts(way=math.nextafter(0.5e-3, 0.0))
    assert not lasts(then=-0.0079), "since the next reading only"
    assert not lasts(last=math.nextafter(0.003, 0.0))


@pytest.mark.parametrize(("missing", "is_found"), [(9.0, True), (8.99, False)])
def test_exactly_so_much_is_too_much(missing, is_found):
    watch = UnseenPull(MASS, PLAIN)
    for k in range(30):
        at(watch, k * CYCLE, k * 2.0**-13, 8.0 - missing)
    assert watch.lasts is is_found


def test_what_was_twenty_milliseconds_ago_counts_yet():
    for first, runs in ((0.0, True), (math.nextafter(0.0, -1.0) - 1e-9, False)):
        watch = at(UnseenPull(MASS, PLAIN), first, 0.0)
        for t in (0.01, 0.02):
            at(watch, t, 1.6e-3)
        assert watch.runs is runs
    assert not at(at(UnseenPull(MASS, PLAIN), 0.0, 0.0), 0.01, 1.5e-3).runs
    late = at(UnseenPull(MASS, PLAIN), 5.0, 0.0)
    for t in (5.004, 5.0079):
        at(late, t, 1.0, 0.0)
    assert not at(late, 5.0079 + 0.0001, 1.0, 0.0).lasts, "the time since counts, not the time"


def test_two_readings_of_one_time_take_no_friction():
    watch = UnseenPull(MASS, PLAIN)
    for k in range(30):
        for share in (0.0, 1.0):  # half of the way, in no time
            at(watch, k * CYCLE, (k + share) * 2.0**-12, 20.0)
    assert not watch.lasts


def test_what_was_lost_before_does_not_count():
    """A long way without any pull, a rest, and an even motion that its pull explains."""
    watch, friction = UnseenPull(MASS, FRICTION), 0.8 * (FRICTION.coulomb + 0.1 * FRICTION.viscous)
    for k in range(60):
        at(watch, k * CYCLE, k * 0.1 * CYCLE)
    assert watch.lasts
    for k in range(60, 120):
        at(watch, k * CYCLE, k * 0.1 * CYCLE, friction)
    assert not watch.lasts
