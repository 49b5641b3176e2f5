"""A rod that does not follow, has run off by itself, or moves while nothing leads it."""

import numpy as np
import pytest
from test_pneumatic_tracking_alarm import ALARM, FOLLOWING, PERIOD, run, watch

from rig.hal import LimitExceeded, SafetyError
from rig.mechanisms.pneumatic.alarms.settings import OscillationAlarm
from rig.mechanisms.pneumatic.alarms.tracking import Strayed, TrackingWatch


def test_what_stands_off_its_reference_is_said_to_stick_and_what_runs_away_is_not():
    def of(wanted, measured):
        return str(run(wanted, lambda t: measured(t) - wanted(t), 4.0)[1])

    stuck = of(lambda t: 0.0 if t < 2.0 else 8e-3 * (t - 2.0), lambda t: 0.0)
    assert "following error of the pair" in stuck
    assert "it sticks, with more friction than the profile says, or is held" in stuck
    runs = of(lambda t: 10e-3 * t, lambda t: 10e-3 * t - 8e-3 * max(t - 1.0, 0.0))
    assert "following error of the pair" in runs
    assert "sticks" not in runs


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_rod_that_is_lost_for_too_long_is_a_fault_with_its_bound(side):
    found = run(lambda t: 1e-3, lambda t: side * 3.01e-3 if t > 0.5 else 0.0, 2.0)
    assert found is not None
    t, fault = found
    assert isinstance(fault, LimitExceeded)
    assert t == pytest.approx(0.5 + ALARM.lost, abs=3 * PERIOD)
    assert "following error of the pair for 0.3 s" in str(fault)
    assert "outside -3 … 3 mm" in str(fault)
    assert run(lambda t: 1e-3, lambda t: side * 2.99e-3, 2.0) is None


def test_a_step_is_given_its_time():
    assert run(lambda t: 5e-3, lambda t: -5e-3 if t < 0.29 else 0.0, 1.0) is None
    assert run(lambda t: 5e-3, lambda t: -5e-3 if t < 0.31 else 0.0, 1.0) is not None


@pytest.mark.parametrize("seed", range(6))
def test_a_rod_that_runs_off_by_itself_is_given_no_time(seed):
    drawn = np.random.default_rng(seed)
    side = float(drawn.choice([-1.0, 1.0]))
    speed, since = float(drawn.uniform(0.03, 0.4)), float(drawn.uniform(0.1, 0.5))
    slope = float(drawn.uniform(-5e-3, 5e-3))  # of what is followed
    place = float(drawn.uniform(-30e-3, 30e-3))

    def error(t):
        return side * speed * max(t - since, 0.0)

    t, fault = run(lambda t: place + slope * t, error, 2.0)
    assert t == pytest.approx(since + 2.0 * FOLLOWING / speed, abs=2 * PERIOD)
    assert isinstance(fault, LimitExceeded)
    assert "following error of the pair that its own motion brought about" in str(fault)
    assert "outside -6 … 6 mm" in str(fault)


def stray(wanted, measured, at=1.0):
    """Return what is raised where a rod followed at 0.25 m, and is elsewhere at an instant."""
    alarm = OscillationAlarm(amplitude=100.0, lost=0.5)
    watched = watch(following=2.0, alarm=alarm, names=("a", "b"))
    watched.check((0.0, 0.25), (0.0, 0.25), 0.0)
    try:
        watched.check((0.0, wanted), (0.0, measured), at)
    except Strayed as strayed:
        return strayed
    return None


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_twice_as_far_off_and_half_of_it_by_itself_are_bounds(side):
    def off(error, way, at=0.25):
        here = 0.25 + side * way
        return stray(here - side * error, here, at)

    assert off(4.0, 3.0) is None, "not more than twice"
    assert off(4.5, 2.0) is None, "not more than half by itself"
    ran = off(4.5, 2.5)
    assert (ran.value, ran.lower, ran.upper) == (side * 4.5, -4.0, 4.0)
    assert (ran.rod, ran.ran) == (1, True)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_who_has_gone_half_of_what_is_too_much_by_itself_has_not_lagged(side):
    for error, way, ran in ((3.0, 0.5, False), (3.0, 0.75, True), (3.5, 0.75, False)):
        here = 0.25 + side * way
        found = stray(here - side * error, here)
        assert (found.rod, found.ran) == (1, ran), (error, way)
        assert (found.value, found.upper) == (side * error, 2.0)


def test_what_its_own_pressures_have_driven_off_is_left_to_the_swings():
    """They are asked once: a loop that swings pulls back before it has come back."""
    asked = []

    def driven(k, error):
        asked.append((k, error))
        return len(asked) == 1

    alarm = OscillationAlarm(amplitude=100.0, lost=10.0)
    watched = watch(following=2.0, alarm=alarm, names=("a", "b"))
    for t, here in ((0.0, 0.25), (0.25, -4.5), (0.5, -5.0), (0.75, 0.25)):
        watched.check((0.0, 0.25), (0.0, here), t, driven=driven)
    assert asked == [(1, -4.75)]
    with pytest.raises(Strayed):
        watched.check((0.0, 0.25), (0.0, 5.0), 1.0, driven=driven)
    assert asked[1:] == [(1, 4.75)], "it had come back, and is asked after again"


def test_an_error_of_nobody_in_particular_is_that_of_the_first_and_has_lagged():
    plain = Strayed("following error", 1.0, -0.5, 0.5, "m")
    assert (plain.rod, plain.ran) == (0, False)


@pytest.mark.parametrize("share", [0.0, 0.45])
def test_a_rod_that_its_reference_leaves_behind_has_its_time(share):
    """It may even go the other way, for less than what a rod may be off."""
    for side in (-1.0, 1.0):
        found = run(
            lambda t, side=side: side * 20e-3 * t,
            lambda t, side=side: -side * min((1.0 + share) * 20e-3 * t, 6.1e-3 + share * 6.1e-3),
            1.0,
        )
        t, fault = found
        assert t > ALARM.lost
        assert "by itself" not in str(fault)
        assert "for 0.3 s" in str(fault)


def held_for(since, until, why="a chamber leaks"):
    """Let a rod follow at one instant, and not at another; say why it is held."""
    watched = watch()
    watched.check((0.0,), (0.0,), since, lambda: why)
    watched.check((0.0,), (FOLLOWING + 1e-4,), until, lambda: why)


def test_what_is_held_is_told_once_no_seal_lets_go_so_late():
    held_for(1.0, 1.05 - 1e-6)
    held_for(0.0, 0.05)
    with pytest.raises(SafetyError, match=r"^a chamber leaks \[the pair stays 3.1 mm off its"):
        held_for(0.0, 0.05 + 1e-6)
    held_for(0.0, 0.2, None)  # nobody knows why: it has its time


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_nothing_moves_while_chambers_fill(sign):
    watched = watch(names=("the rod of ch1", "the rod of ch2"))
    home, away = (0.25, 0.5), sign * 2.0**-9
    watched.check_still(home, (home[0] + away, home[1]), 1.0)
    bound = sign * FOLLOWING
    with pytest.raises(LimitExceeded, match="way of the rod of ch2 while nothing controls it"):
        watched.check_still(home, (home[0], home[1] + 1.01 * bound), 2.0)
    with pytest.raises(LimitExceeded) as told:
        watched.check_still((0.0, 0.0), (2.0 * bound, 0.0), 3.0)
    fault = told.value
    assert (fault.value, fault.lower, fault.upper) == (2.0 * bound, -FOLLOWING, FOLLOWING)
    with pytest.raises(LimitExceeded) as told:
        watched.check_still(home, (home[0] + 2.0 * bound, home[1]), 4.0)
    assert told.value.value == pytest.approx(2.0 * bound)
    watched.check_still((0.0, 0.0), (bound, -bound), 5.0)
    # A procedure that follows nothing has a bound of its own.
    watched.check_still((0.0, 0.0), (bound, -bound), 6.0, most=2.0 * FOLLOWING)
    watched.check_still((0.0, 0.0), (0.5 * bound, 0.0), 7.0, most=0.5 * FOLLOWING)
    with pytest.raises(LimitExceeded) as told:
        watched.check_still((0.0, 0.0), (0.51 * bound, 0.0), 8.0, most=0.5 * FOLLOWING)
    assert (told.value.lower, told.value.upper) == (-0.5 * FOLLOWING, 0.5 * FOLLOWING)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_what_has_strayed_for_long_says_that_it_lasted_and_what_runs_does_not(side):
    def caught(errors, driven):
        watched = TrackingWatch(("the pair",), 3e-3, OscillationAlarm(lost=0.25))
        with pytest.raises(Strayed) as raised:
            for k, error in enumerate(errors):
                watched.check((0.0,), (side * error,), 0.125 * k, driven=lambda k, off: driven)
        return raised.value

    assert not caught([0.0, 7e-3], driven=False).lasted
    assert caught([0.0, 4e-3, 4e-3, 4e-3], driven=True).lasted


def test_what_strays_says_how_far_all_are_off():
    watched = TrackingWatch(("one", "other"), 2e-3, OscillationAlarm(lost=5e-3))
    with pytest.raises(Strayed) as caught:
        for k in range(9):
            watched.check((1e-3, 5e-3), (0.5e-3, 8e-3), 1e-3 * k)
    assert caught.value.rod == 1
    assert caught.value.offs == pytest.approx([-0.5e-3, 3e-3])


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_what_runs_off_has_a_bound_of_its_own_where_a_calibration_lets_rods_stray(side):
    def strayed(speed, driven=False):
        """Return how far off it is found, m, and what is said; None: it is not."""
        alarm = OscillationAlarm(lost=10.0)
        watched = TrackingWatch(("the pair",), 0.5, alarm, run_off=2.0**-7)
        for k in range(100):
            off = side * speed * k
            try:
                watched.check((0.25,), (0.25 + off,), 0.125 * k, driven=lambda k, off: driven)
            except Strayed as error:
                return abs(off), error
        return None

    off, error = strayed(2.0**-10)
    assert off == 9.0 * 2.0**-10, "the first beyond it"
    assert (error.lower, error.upper, error.ran) == (-(2.0**-7), 2.0**-7, True)
    assert strayed(2.0**-14) is None, "it has not got so far"
    assert strayed(2.0**-10, driven=True) is None
    # What is left behind as its reference goes has not run.
    watched = TrackingWatch(("the pair",), 0.5, OscillationAlarm(lost=10.0), run_off=2.0**-7)
    for k in range(100):
        watched.check((side * 2.0**-10 * k,), (0.0,), 0.125 * k)
