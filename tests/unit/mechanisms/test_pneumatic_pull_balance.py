"""A pull that no monitor shows is told from friction, whatever the pair does."""

import dataclasses
import math

import numpy as np
import pytest

from rig.mechanisms.pneumatic.alarms.balance import UNSTABLE, PullBalance
from rig.mechanisms.pneumatic.alarms.missing import Instant, missing_pull
from rig.mechanisms.pneumatic.settings import SealFriction

FRICTION = SealFriction(coulomb=10.4, breakaway=13.4, stribeck_velocity=8e-3, viscous=50.0)
MASS = 0.138


def slide(shown, true, friction_scale, start, period):
    """Return the history of a pair that slides under a pull of which monitors show a part, N."""
    history, place, speed, fine = [], 0.0, start, period / 50.0
    for k in range(round(0.03 / period)):
        history.append(Instant(k * period, place, shown))
        for _ in range(50):
            drag = friction_scale * (
                FRICTION.coulomb * np.tanh(speed / 1e-4) + FRICTION.viscous * speed
            )
            speed += fine * (true - drag) / MASS
            place += fine * speed
    return history


@pytest.mark.parametrize("seed", range(20))
def test_a_chamber_that_empties_while_the_pair_slides_is_found(seed):
    rng = np.random.default_rng(seed)
    sign = rng.choice([-1.0, 1.0])
    shown, unseen = sign * rng.uniform(0.0, 15.0), sign * rng.uniform(25.0, 45.0)
    history = slide(
        shown, shown + unseen, rng.uniform(0.85, 1.5), sign * 0.02, rng.choice([1e-3, 2e-3])
    )
    missing = missing_pull(history, MASS, FRICTION)
    assert np.sign(missing) == sign
    assert abs(missing) < abs(unseen) * 1.2


@pytest.mark.parametrize("seed", range(20))
def test_what_the_monitors_show_needs_no_other_cause(seed):
    rng = np.random.default_rng([1, seed])
    sign = rng.choice([-1.0, 1.0])
    pull = sign * rng.uniform(12.0, 60.0)
    history = slide(pull, pull, rng.uniform(0.7, 1.6), sign * rng.uniform(0.0, 0.3), 1e-3)
    assert missing_pull(history, MASS, FRICTION) == 0.0


def test_seals_hold_so_much_and_no_more():
    def held(pull):
        return [Instant(1e-3 * k, 5e-3, pull) for k in range(40)]

    most = 1.6 * FRICTION.breakaway
    assert missing_pull(held(most), MASS, FRICTION, sticks=True) == 0.0
    assert missing_pull(held(-most - 20.0), MASS, FRICTION, sticks=True) == pytest.approx(20.0)
    moving = slide(0.0, 40.0, 1.0, 0.02, 1e-3)
    assert missing_pull(moving, MASS, FRICTION) > 0.0
    assert missing_pull(moving, MASS, FRICTION, sticks=True) == 0.0


def test_too_short_a_past_tells_nothing():
    assert missing_pull([], MASS, FRICTION) == 0.0
    assert missing_pull([Instant(1e-3 * k, 0.0, 90.0) for k in range(6)], MASS, FRICTION) == 0.0


PLAIN = SealFriction(coulomb=10.0, breakaway=10.0, stribeck_velocity=8e-3, viscous=0.0)
HOLDS, SURE = 16.0, 7.0
"""What its seals hold at most, and what is friction yet, N."""


def rests(*pulls, step=0.01, start=0.0):
    """Return the history of a pair that does not move."""
    return [Instant(start + k * step, 5e-3, pull) for k, pull in enumerate(pulls)]


def test_the_mean_of_the_last_twenty_milliseconds_counts():
    last = rests(90.0, 30.0, 30.0)
    assert missing_pull(last, MASS, PLAIN) == pytest.approx(-(50.0 - HOLDS))
    assert missing_pull([Instant(-1e-9, 5e-3, 900.0), *last], MASS, PLAIN) == pytest.approx(
        -(50.0 - HOLDS)
    )


def test_eight_milliseconds_are_needed():
    for step, found in ((8e-3, True), (math.nextafter(8e-3, 0.0), False)):
        assert (missing_pull(rests(90.0, 90.0, step=step), MASS, PLAIN) != 0.0) is found
    assert missing_pull(rests(90.0, 90.0, step=7e-3, start=5.0), MASS, PLAIN) == 0.0


def test_what_may_be_friction_is_not_missing():
    most = HOLDS + SURE
    assert missing_pull(rests(most, most, most), MASS, PLAIN) == 0.0
    assert missing_pull(rests(-most, -most, -most), MASS, PLAIN) == 0.0
    more = math.nextafter(most, math.inf)
    assert missing_pull(rests(more, more, more), MASS, PLAIN) == pytest.approx(-SURE)
    assert missing_pull(rests(-more, -more, -more), MASS, PLAIN) == pytest.approx(SURE)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_half_a_millimetre_is_a_motion(sign):
    for way, sticks in ((0.5e-3, False), (math.nextafter(0.5e-3, 0.0), True)):
        moved = [Instant(k * 0.01, sign * way * k / 2.0, 90.0) for k in range(3)]
        found = missing_pull(moved, MASS, PLAIN, sticks=True)
        assert (found != 0.0) is sticks


def moves(place, pull, period=1e-3, last=0.02):
    """Return the history of a pair that is somewhere at each time."""
    return [Instant(k * period, place(k * period), pull) for k in range(round(last / period) + 1)]


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_steady_motion_takes_eight_tenths_of_the_friction(sign):
    speed = sign * 0.1
    friction = dataclasses.replace(PLAIN, viscous=50.0)
    history = moves(lambda t: 1e-3 + speed * t, -sign * 4.0)
    drag = 0.8 * (10.0 + 50.0 * abs(speed))
    assert missing_pull(history, MASS, friction) == pytest.approx(sign * (drag + 4.0))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("period", [1e-3, 4e-3])
def test_what_gets_faster_has_got_energy(sign, period):
    """Speeds at the ends are means over four milliseconds."""
    slow, more = 0.2, 50.0
    history = moves(lambda t: sign * (slow * t + 0.5 * more * t * t), 0.0, period)
    way = abs(history[-1].place - history[0].place)
    first, last = slow + more * 2e-3, slow + more * 18e-3
    gained = 0.5 * MASS * (last**2 - first**2)
    assert missing_pull(history, MASS, PLAIN) == pytest.approx(sign * (gained / way + 8.0))
    # Braked instead, it has given that energy to its seals.
    braked = moves(lambda t: sign * (1.2 * t - 0.5 * more * t * t), 0.0)
    assert missing_pull(braked, MASS, PLAIN) == 0.0


def test_seals_take_their_share_on_the_way_back_too():
    """An agonist that pulls more and more, and a pair that is 2 mm farther, and back by 1 mm."""
    places, pulls = [0.0] * 5 + [2e-3] * 5 + [1e-3] * 11, np.linspace(-1.0, 1.0, 21)
    friction = dataclasses.replace(PLAIN, viscous=1.0)
    history = [
        Instant(k * 1e-3, place, pull)
        for k, (place, pull) in enumerate(zip(places, pulls, strict=True))
    ]
    taken = 0.8 * (10.0 * 3e-3 + 1.0 * (2e-3**2 + 1e-3**2) / 1e-3)
    done = 0.5 * (pulls[4] + pulls[5]) * 2e-3 - 0.5 * (pulls[9] + pulls[10]) * 1e-3
    assert missing_pull(history, MASS, friction) == pytest.approx((taken - done) / 1e-3)


AREA = 2e-4
CHANNELS = ("ch1", "ch2", "ch3", "ch4")


def balance(falling=None, area=AREA, beside=0.0):
    """Return what watches two pairs, each of a wire and the next but one."""
    told = {}
    if falling is not None:
        told = {"falls": lambda off, other: falling * off + beside * abs(other)}
    return PullBalance(
        area, MASS, PLAIN, ((0, 2), (1, 3)), CHANNELS, "regulators", "the ring", **told
    )


def told(watch, *pressures, rods=(0.0,) * 4, cycles=21, period=1e-3):
    for k in range(cycles):
        watch.note(k * period, rods, pressures)
    return watch


def test_it_names_the_chamber_that_pulls_less_and_by_how_much():
    for pressures, name in (((300e3, 0.0, 100e3, 0.0), "ch1"), ((100e3, 0.0, 300e3, 0.0), "ch3")):
        said = told(balance(), *pressures).explain()
        assert said == (
            f"regulators: the chamber of {name} leaks behind its tube, or its monitor is off, or "
            "the ring is pushed or held, or has more friction than the profile says "
            "(`rig calibrate RIG friction` measures it): 24 N are not those of the pressures"
        )
    assert told(balance(), 300e3, 300e3, 300e3, 300e3).explain() is None


@pytest.mark.parametrize(("missing", "seals"), [(9.99, True), (10.01, False)])
def test_seals_come_first_where_as_much_again_would_hold_the_pair(missing, seals):
    said = told(balance(), 300e3, 0.0, 300e3 - (HOLDS + missing) / AREA, 0.0).explain()
    first = "the ring has more friction than the profile says" if seals else "the chamber of ch1"
    assert said.startswith(f"regulators: {first}")
    assert "the chamber of ch1 leaks behind its tube, or its monitor is off" in said
    assert said.endswith(": 10 N are not those of the pressures")


def test_friction_is_no_cause_of_what_moves_by_itself():
    watch = balance()
    for k in range(21):
        way = 50e-6 * k
        watch.note(1e-3 * k, (way, 0.0, -way, 0.0), (0.0, 0.0, 150e3, 0.0))
    said = watch.explain()
    assert said is not None and "is pushed or held: " in said
    assert "friction" not in said


def test_of_two_pairs_the_one_that_lacks_more_is_named_first():
    said = told(balance(), 250e3, 100e3, 100e3, 300e3).explain()
    assert "the chamber of ch4 or ch1 leaks" in said and ": 24 N are" in said
    said = told(balance(), 300e3, 100e3, 100e3, 250e3).explain()
    assert "the chamber of ch1 or ch4 leaks" in said and ": 24 N are" in said


def test_a_ring_that_leans_falls_on():
    """By what its four tensions have on average, over how far it is off its middle."""
    leans = (4e-3, 0.0, -2e-3, 0.0)
    pressures = (150e3, 50e3, 50e3, 150e3)
    assert told(balance(), *pressures, rods=leans).explain() is None
    # 100 kPa on average, 3 mm off: 100 kPa more to the difference of 100 kPa.
    said = told(balance(1000.0 / 3.0), *pressures, rods=leans).explain()
    assert "the chamber of ch1 leaks" in said and ": 24 N are" in said
    assert told(balance(-1000.0 / 3.0), *pressures, rods=leans).explain() is None


def test_it_falls_by_how_far_the_other_pair_is_off_as_well():
    pressures = (150e3, 50e3, 50e3, 150e3)
    for leans in ((0.0, 4e-3, 0.0, -2e-3), (0.0, -4e-3, 0.0, 2e-3)):
        said = told(balance(0.0, beside=1000.0 / 3.0), *pressures, rods=leans).explain()
        assert "the chamber of ch1 leaks" in said and ": 24 N are" in said
        assert told(balance(0.0, beside=-1000.0 / 3.0), *pressures, rods=leans).explain() is None


def slid(way, *pressures, rods=(0.0,) * 4):
    """Return a balance of pairs whose first one has gone a way, and stands if that was short."""
    watch = balance()
    for k in range(21):
        place = way * k / 20
        watch.note(1e-3 * k, (rods[0] + place, rods[1], rods[2] - place, rods[3]), pressures)
    return watch


@pytest.mark.parametrize("off", [4e-3, -4e-3])
def test_what_has_run_off_and_goes_on_lacks_what_should_pull_it_back(off):
    runs = slid(math.copysign(3e-3, off), 100e3, 100e3, 100e3, 100e3)
    said = runs.explain_strayed(off, 0, ran=True, lasted=True)
    assert said == runs.explain_gone(off, 0) + UNSTABLE
    assert f"the chamber of {'ch3' if off > 0.0 else 'ch1'} leaks" in said


@pytest.mark.parametrize("ran", [True, False])
def test_what_has_run_off_and_stands_does_so_for_a_reason_only_if_more_pulls_it_back(ran):
    held = slid(0.0, 100e3, 100e3, 140e3, 100e3)
    assert held.explain_strayed(4e-3, 0, ran=ran, lasted=True) is None, "seals hold so much"
    just = held.explain_strayed(4e-3, 0, ran=ran, lasted=False)
    assert just == (held.explain_gone(4e-3, 0) + UNSTABLE if ran else None)
    torn = slid(0.0, 100e3, 100e3, 190e3, 100e3)
    assert "18 N pull it back" in torn.explain_strayed(4e-3, 0, ran=ran, lasted=True)
    assert torn.explain_strayed(-4e-3, 0, ran=ran, lasted=True) is None, "it is pulled there"


def test_it_is_the_first_pair_if_none_is_named():
    torn = slid(0.0, 100e3, 100e3, 190e3, 100e3)
    assert torn.explain_strayed(4e-3, ran=False, lasted=True) is not None


def test_what_pulls_back_is_the_mean_of_all_late_cycles():
    watch = balance()
    for k in range(21):
        watch.note(1e-3 * k, (0.0,) * 4, (0.0, 0.0, 240e3 * (k % 2), 0.0))
    assert ": it stays off though 23 N pull it back" in watch.explain_off(4e-3, 0)


def test_who_has_no_past_has_run_off():
    said = balance().explain_strayed(4e-3, 0, ran=True, lasted=True)
    assert said == balance().explain_gone(4e-3, 0) + UNSTABLE


def test_where_nothing_falls_a_place_pulls_at_nothing():
    """As much as friction may be is no pull yet; a micronewton more is one."""
    pressures = ((HOLDS + SURE) / AREA, 0.0, 0.0, 0.0)
    assert told(balance(), *pressures, rods=(4e-3, 0.0, -2e-3, 0.0)).explain() is None
    assert told(balance(1e-3), *pressures, rods=(4e-3, 0.0, -2e-3, 0.0)).explain() is not None


def test_a_little_that_is_missing_has_a_direction_too():
    slippery = SealFriction(coulomb=0.1, breakaway=0.1, stribeck_velocity=8e-3, viscous=0.0)
    for pressures, name in (((3e3, 0.0), "a"), ((0.0, 3e3), "b")):
        watch = PullBalance(AREA, MASS, slippery, ((0, 1),), ("a", "b"), "regulators", "it")
        assert f"the chamber of {name} leaks" in told(watch, *pressures, rods=(0.0, 0.0)).explain()


def test_a_new_motion_has_no_past():
    watch = told(balance(), 300e3, 0.0, 100e3, 0.0)
    watch.restart()
    assert watch.explain() is None
    assert told(watch, 300e3, 0.0, 100e3, 0.0, cycles=9).explain() is not None


def test_256_cycles_are_remembered():
    for cycles, is_told in ((256, False), (255, True)):
        watch = balance()
        watch.note(0.0, (0.0,) * 4, (32e6, 0.0, 0.0, 0.0))
        for k in range(1, cycles + 1):
            watch.note(k * 0.05e-3, (0.0,) * 4, (50e3, 0.0, 0.0, 0.0))
        assert (watch.explain() is not None) == is_told


def run_of_two(first, *, stands=0):
    """Return what watches pairs of which one lost air and ran, and after it takes the other along.

    The other one lacks more in the end: what throws it is the ring.
    """
    watch, here, there, against = balance(), 0.0, 0.0, 0.0
    for k in range(100):
        here += 0.1e-3 if k >= 10 else 0.0
        there += 0.4e-3 if k >= 70 else 0.0
        against = 75e3 if k < 50 else -75e3  # by then its opponent has as little
        if 60 <= k < 60 + stands:
            here -= 0.1e-3
        rods, pressures = [-here, -there, here, there], [against, 150e3, 0.0, 0.0]
        if first:
            rods, pressures = rods[1::-1] + rods[:1:-1], pressures[1::-1] + pressures[:1:-1]
        watch.note(k * 1e-3, tuple(rods), tuple(pressures))
    return watch.explain()


@pytest.mark.parametrize(("first", "weak", "other"), [(0, "ch1", "ch2"), (1, "ch2", "ch1")])
def test_a_run_is_explained_by_how_it_began(first, weak, other):
    assert f"the chamber of {weak} leaks" in run_of_two(first)
    assert f"the chamber of {other} leaks" in run_of_two(first, stands=25)


def test_what_was_explained_before_a_chamber_emptied_is_no_explanation_of_what_came_after():
    watch = balance()
    for k in range(60):
        place = 0.2e-3 * k
        driven = 100e3 if k < 30 else 0.0
        watch.note(k * 1e-3, (place, 0.0, -place, 0.0), (driven, 0.0, 0.0, 0.0))
    assert "the chamber of ch3 leaks" in watch.explain()


@pytest.mark.parametrize(("later", "together"), [(4, True), (20, False)])
def test_pairs_that_lack_pull_at_about_the_same_time_are_named_together(later, together):
    watch, period = balance(), 2.0**-10
    for k in range(80):
        one, other = 0.3e-3 * max(k - 40, 0), 0.3e-3 * max(k - 40 - later, 0)
        watch.note(k * period, (one, other, -one, -other), (0.0,) * 4)
    said = watch.explain()
    assert ("ch3 or ch4" in said or "ch4 or ch3" in said) is together, said
    assert "ch3" in said


def test_only_what_sticks_is_asked_after_if_so_wanted():
    watch = balance()
    for k in range(21):
        place = 1e-4 * k
        watch.note(k * 1e-3, (place, 0.0, -place, 0.0), (0.0,) * 4)
    assert "the chamber of ch3 leaks" in watch.explain()
    assert watch.explain(sticks=True) is None
