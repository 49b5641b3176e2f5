"""A pair that stays off its reference, creeps or loses air is told with the chamber that is why."""

import math

import numpy as np
import pytest
from test_pneumatic_pull_balance import AREA, MASS, PLAIN, balance, told

from rig.mechanisms.pneumatic.alarms.balance import PullBalance
from rig.mechanisms.pneumatic.settings import SealFriction

# Off its reference, and pulled back --------------------------------------------------------------


def stays(pull, off):
    """Return what is said of a pair that stays off though its monitors show a pull, N."""
    balance = PullBalance(
        1.0, MASS, PLAIN, ((0, 1),), ("agonist", "antagonist"), "regulators", "the carriage"
    )
    for k in range(30):
        balance.note(1e-3 * k, (off, -off), (100.0 + pull, 100.0))
    return balance.explain_off(off)


@pytest.mark.parametrize(("off", "back"), [(6e-3, "antagonist"), (-6e-3, "agonist")])
def test_what_does_not_come_back_though_it_is_pulled_has_less_air_than_its_monitor_says(off, back):
    against = math.copysign(2.0 * PLAIN.breakaway + 1e-9, -off)
    assert stays(against, off) == (
        f"regulators: the chamber of {back} leaks behind its tube, or its monitor is off, or the "
        "carriage is pushed or held, or has more friction than the profile says "
        f"(`rig calibrate RIG friction` measures it): it stays off though {abs(against):.0f} N "
        "pull it back"
    )
    # Seals wear, and units differ: what is still as strong as they may be comes after them.
    for strength in (10.0 + 1e-9, 2.0 * PLAIN.breakaway - 1e-9):
        against = math.copysign(strength, -off)
        assert stays(against, off) == (
            "regulators: the carriage has more friction than the profile says (`rig calibrate RIG "
            f"friction` measures it), or is pushed or held, or the chamber of {back} leaks behind "
            f"its tube, or its monitor is off: it stays off though {strength:.0f} N pull it back"
        )
    assert stays(math.copysign(10.0 - 1e-9, -off), off) is None  # its seals may hold that
    assert stays(math.copysign(10.0, -off), off) is None  # and just that
    assert stays(-against, off) is None  # nothing pulls it back


def test_twenty_milliseconds_are_just_that():
    for first, driven in ((0.0, True), (math.nextafter(0.0, -1.0), False)):
        watch = PullBalance(1.0, MASS, PLAIN, ((0, 1),), ("a", "b"), "regulators", "it")
        for t, pull in ((first, 90.0), (0.01, 0.0), (0.02, 0.0)):
            watch.note(t, (0.0, 0.0), (pull, 0.0))
        assert watch.drives(1e-3, 0) is driven


def two_pairs():
    """Return the balance of two pairs, of which the second is pulled by 45 N."""
    return told(balance(), 300e3, 400e3, 300e3, 150e3)


@pytest.mark.parametrize(("off", "weak"), [(5e-3, "ch4"), (-5e-3, "ch2")])
def test_each_pair_is_asked_after_by_its_number(off, weak):
    pulled = two_pairs()
    assert pulled.explain_off(off, 0) is None
    back = pulled.explain_off(off, 1)
    assert (back is None) is (off > 0.0), "it is pulled to where it is off"
    if back is not None:
        assert f"the chamber of {weak} leaks" in back
    assert pulled.explain_gone(off, 1) == (
        f"regulators: the chamber of {weak} leaks behind its tube, or its monitor is off, or "
        "the ring is pushed or held"
    )
    gone = pulled.explain_gone(off, 0)
    assert f"the chamber of {'ch3' if off > 0.0 else 'ch1'} leaks" in gone


def test_a_pair_is_driven_where_its_pressures_pull_it_beyond_its_friction():
    watch = two_pairs()
    assert watch.drives(5e-3, 1)
    assert not watch.drives(-5e-3, 1)
    assert not watch.drives(5e-3, 0) and not watch.drives(-5e-3, 0)
    edge = PLAIN.coulomb / AREA
    assert AREA * edge == PLAIN.coulomb
    for pull, driven in ((edge * (1.0 + 1e-9), True), (edge, False)):
        for side in (1.0, -1.0):
            pressures = (300e3 + side * pull, 300e3, 300e3, 300e3)
            assert told(balance(), *pressures).drives(side * 1e-3, 0) is driven
    assert balance().drives(1e-3, 0) is False, "nothing was seen"


def test_before_anything_was_seen_nothing_is_said_of_what_is_off():
    balance = PullBalance(1.0, MASS, PLAIN, ((0, 1),), ("a", "b"), "regulators", "the carriage")
    assert balance.explain_off(1e-3) is None


def test_the_rods_of_the_last_cycles_are_kept_in_their_order():
    watch = balance()
    each = [(1e-3 * k, 0.0, -1e-3 * k, 0.0) for k in range(70)]
    for k, rods in enumerate(each):
        watch.note(1e-3 * k, rods, (0.0,) * 4)
    assert watch.rods == each[-64:]
    watch.restart()
    assert watch.rods == []


def ran(out, fall, late=0.02):
    """Return the balance after a rod has gone out by `out` m while its pressure fell by so much."""
    watch = balance()
    rods, pressures = [0.0] * 4, [400e3] * 4
    watch.note(0.0, tuple(rods), (500e3,) * 4)
    for k in (0.0, 0.5, 1.0):
        rods[3], pressures[3] = -out * k, 400e3 - fall * k
        watch.note(1.0 + late * k, tuple(rods), tuple(pressures))
    return watch


def test_a_chamber_that_loses_air_while_its_rod_is_drawn_out_is_no_push():
    """Pressed air has more pressure; what was 20 ms before counts, and nothing earlier."""
    emptied = ran(3e-3, 15.001e3).explain_emptied(1)
    assert emptied == (
        "regulators: the chamber of ch4 leaks behind its tube, or its monitor is off, or the ring "
        "is pushed or held"
    )
    assert ran(3e-3, 15.001e3).explain_emptied(0) is None
    assert ran(3e-3, 15e3).explain_emptied(1) is None
    assert ran(3e-3, 15.001e3, late=0.021).explain_emptied(1) is None
    assert ran(0.0, 50e3).explain_emptied(1) is None  # it stands
    assert ran(-3e-3, 50e3).explain_emptied(1) is None  # the air has more room
    assert balance().explain_emptied(0) is None


def test_of_each_pair_either_chamber_may_lose_its_air():
    for weak in range(4):
        watch = balance()
        for k in (0.0, 1.0):
            rods, pressures = [0.0] * 4, [400e3] * 4
            rods[weak], pressures[weak] = -1e-3 * k, 400e3 - 16e3 * k
            watch.note(0.01 * k, tuple(rods), tuple(pressures))
        said = watch.explain_emptied(weak % 2)
        assert f"the chamber of ch{weak + 1} leaks" in said
        assert watch.explain_emptied(1 - weak % 2) is None


# What crept -----------------------------------------------------------------------------------


def of_one_pair(friction=PLAIN):
    return PullBalance(1.0, MASS, friction, ((0, 1),), ("a", "b"), "regulators", "the carriage")


def creeps(places, pull, watch=None):
    """Return what is said of a pair that goes through places (m) under a pull, N."""
    watch = watch or of_one_pair()
    for k, place in enumerate(places):
        watch.note(0.1 * k, (place, -place), (100.0 + pull, 100.0))
    return watch.explain_crept(0)


HALF = np.linspace(0.0, 0.5001e-3, 11)


@pytest.mark.parametrize(("sign", "weak"), [(1.0, "b"), (-1.0, "a")])
def test_a_pair_that_crept_against_its_pull_has_less_air_than_its_monitors_say(sign, weak):
    assert creeps(sign * HALF, -sign * 12.0) == (
        f"regulators: the chamber of {weak} leaks behind its tube, or its monitor is off, or the "
        "carriage is pushed or held: what last moved it was 20 N more than pressures"
    )
    # Seals take 8 N of 10 at least, and 7 N are sure.
    assert "was 7 N more" in creeps(sign * HALF, sign * 0.9)
    assert creeps(sign * HALF, sign * 1.1) is None


def test_it_is_the_last_half_millimetre_that_tells_however_far_it_went_before():
    assert creeps(0.99 * HALF, -12.0) is None
    assert creeps(HALF[:1], -12.0) is None
    assert creeps([], -12.0) is None
    watch = of_one_pair()
    assert creeps(HALF, -12.0, watch) is not None
    assert creeps(HALF[-1] + HALF, 12.0, watch) is None, "it went with its pull at last"
    assert creeps(2.0 * HALF[-1] - HALF, 12.0, watch) is not None, "and back against it"
    watch.restart()
    assert watch.explain_crept(0) is None


def test_what_gives_and_comes_back_has_not_crept():
    """Wires and seals give by tens of micrometres whatever pulls; so does an encoder's noise."""
    watch = of_one_pair()
    for k in range(100):
        assert creeps([(-1.0) ** k * 40e-6], 12.0 * (-1.0) ** (k + 1), watch) is None
    for k in range(1000):  # it goes with its pull, and noise goes to and fro on its way
        said = creeps([k * 2e-6 + (-1.0) ** k * 9e-6], 12.0, watch)
        assert said is None
    for k in range(300):
        said = creeps([2e-3 - k * 2e-6 + (-1.0) ** k * 9e-6], 12.0, watch)
    assert "the chamber of a leaks" in said


def test_half_a_millimetre_and_seven_newton_are_the_bounds():
    assert creeps([0.0, 0.5e-3], 1.0) is None
    assert creeps([0.0, 0.5e-3], 1.0 - 1e-9) is not None
    assert creeps([0.0, 0.5e-3 - 1e-9], -12.0) is None


def test_a_pair_that_hardly_needs_a_pull_is_told_with_its_chamber_too():
    slippery = SealFriction(coulomb=0.1, breakaway=0.1, stribeck_velocity=8e-3, viscous=0.0)
    for sign, weak in ((1.0, "b"), (-1.0, "a")):
        assert f"the chamber of {weak}" in creeps(sign * HALF, 0.0, of_one_pair(slippery))


def test_a_way_of_twenty_micrometres_is_one_and_its_pull_counts():
    watch = of_one_pair()
    assert creeps([0.0, 20e-6], 1e3, watch) is None
    assert creeps([0.51e-3], -12.0, watch) is None, "the first pull has done it"


def test_so_many_ways_are_remembered_and_those_that_stand_are_none():
    watch = of_one_pair()
    creeps([0.0, 0.6e-3], -12.0, watch)
    creeps([0.6e-3] * 300, -12.0, watch)
    to_and_fro = [0.6e-3 + (k % 2 == 0) * 30e-6 for k in range(254)]
    assert creeps(to_and_fro, -12.0, watch) is not None
    assert creeps([to_and_fro[0]], -12.0, watch) is None, "the first place is forgotten"
