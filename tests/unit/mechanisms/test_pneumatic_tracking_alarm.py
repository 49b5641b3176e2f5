"""A rod that swings about its reference, or has lost it, on drawn motions."""

import math
import re

import numpy as np
import pytest

from rig.hal import LimitExceeded, SafetyError
from rig.mechanisms.pneumatic.alarms.settings import OscillationAlarm
from rig.mechanisms.pneumatic.alarms.tracking import Strayed, TrackingWatch

PERIOD = 1e-3
FOLLOWING = 3e-3
ALARM = OscillationAlarm(amplitude=1.5e-3, swings=6, slowest=1.0, lost=0.3)


def watch(following=FOLLOWING, alarm=ALARM, names=("the pair",)):
    return TrackingWatch(names, following, alarm)


def run(wanted, error, duration, watched=None):
    """Let functions of time pass; return when it raised and what (None: not at all)."""
    watched = watched or watch()
    for k in range(round(duration / PERIOD)):
        t = k * PERIOD
        goal = wanted(t)
        try:
            watched.check((goal,), (goal + error(t),), t)
        except SafetyError as fault:
            return t, fault
    return None


@pytest.mark.parametrize("seed", range(8))
def test_a_lasting_swing_is_named_with_its_frequency_and_size(seed):
    drawn = np.random.default_rng(seed)
    frequency = float(drawn.uniform(1.0, 30.0))
    size = float(drawn.uniform(1.6e-3, 5e-3))  # peak to peak; less than following either way
    phase = float(drawn.uniform(0.0, 2 * math.pi))
    noise = drawn.normal(0.0, 2e-6, 20_000)
    rest = float(drawn.uniform(-5e-3, 5e-3))

    def error(t):
        swing = 0.5 * size * math.sin(2 * math.pi * frequency * t + phase)
        return swing + float(noise[int(t / PERIOD)])

    found = run(lambda t: rest, error, 10.0)
    assert found is not None
    t, fault = found
    said = re.search(r"the pair oscillates at ([\d.]+) Hz, ([\d.]+) mm peak to peak", str(fault))
    assert said is not None, str(fault)
    # An extreme is known once the rod has come back by the amplitude, which for the smallest
    # swing is near its other end, where a little noise makes a difference.
    assert float(said[1]) == pytest.approx(frequency, rel=0.1, abs=0.06)
    assert float(said[2]) == pytest.approx(size * 1e3, rel=0.06)
    # Six swings, one to begin with, and what the last extreme takes to be known as one.
    assert t < (6.0 / 2.0 + 1.2) / frequency


@pytest.mark.parametrize("seed", range(6))
def test_a_rod_that_stands_and_jumps_is_said_to_stick(seed):
    drawn = np.random.default_rng(200 + seed)
    frequency = float(drawn.uniform(0.6, 6.0))
    size, rest = float(drawn.uniform(1.8e-3, 4e-3)), float(drawn.uniform(-5e-3, 5e-3))
    slips = float(drawn.uniform(0.1, 0.35))  # share of a half period
    noise = drawn.normal(0.0, 2e-6, 20_000)

    def error(t):
        halves, part = divmod(2.0 * frequency * t, 1.0)
        gone = 0.5 * (1.0 - math.cos(math.pi * min(part / slips, 1.0)))
        return (-1.0) ** halves * size * (gone - 0.5) + float(noise[int(t / PERIOD)])

    found = run(lambda t: rest, error, 15.0)
    assert found is not None
    said = re.search(
        r"the pair sticks and slips at ([\d.]+) Hz, .* stands for (\d+) % of the time: its fric",
        str(found[1]),
    )
    assert said is not None, str(found[1])
    assert float(said[1]) == pytest.approx(frequency, rel=0.1, abs=0.06)
    # A cosine goes 30 um at its ends in a small part of its way.
    assert float(said[2]) == pytest.approx(100.0 * (1.0 - slips), abs=15.0)
    assert "regulators are slower" in str(found[1])
    assert "`rig calibrate` measures friction and response" in str(found[1])


def test_what_stands_off_its_reference_is_said_to_stick_and_what_runs_away_is_not():
    def of(wanted, measured):
        return str(run(wanted, lambda t: measured(t) - wanted(t), 4.0)[1])

    stuck = of(lambda t: 0.0 if t < 2.0 else 8e-3 * (t - 2.0), lambda t: 0.0)
    assert "following error of the pair" in stuck
    assert "it sticks, with more friction than the profile says, or is held" in stuck
    runs = of(lambda t: 10e-3 * t, lambda t: 10e-3 * t - 8e-3 * max(t - 1.0, 0.0))
    assert "following error of the pair" in runs
    assert "sticks" not in runs


@pytest.mark.parametrize("seed", range(4))
def test_a_swing_just_below_the_amplitude_never_counts(seed):
    drawn = np.random.default_rng(100 + seed)
    frequency = float(drawn.uniform(1.0, 30.0))
    assert (
        run(lambda t: 0.0, lambda t: 0.74e-3 * math.sin(2 * math.pi * frequency * t), 10.0) is None
    )


@pytest.mark.parametrize("ratio", [0.3, 0.6, 0.69])
def test_a_swing_that_dies_away_is_none(ratio):
    """Each swing has `ratio` of the one before: so does a step that overshoots."""
    frequency = 4.0
    decay = -2.0 * frequency * math.log(ratio)

    def error(t):
        return 25e-3 * math.exp(-decay * t) * math.cos(2 * math.pi * frequency * t)

    assert run(lambda t: 0.0, error, 3.0, watch(following=1.0)) is None


def test_a_swing_that_grows_is_one():
    def error(t):
        return 0.2e-3 * math.exp(1.5 * t) * math.sin(2 * math.pi * 5.0 * t)

    found = run(lambda t: 0.0, error, 5.0)
    assert found is not None
    said = re.search(r"oscillates at ([\d.]+) Hz", str(found[1]))
    assert float(said[1]) == pytest.approx(5.0, rel=0.1)  # a growing swing is left ever sooner


def test_what_swings_only_as_its_reference_does_is_no_oscillation():
    """A lag of a fast sine, and a slip at each of its turns."""

    def wanted(t):
        return 8e-3 * math.sin(2 * math.pi * 2.0 * t)

    def error(t):
        return 2e-3 * math.cos(2 * math.pi * 2.0 * t) + 0.9e-3 * math.sin(2 * math.pi * 6.0 * t)

    assert run(wanted, error, 10.0) is None


def test_a_reference_that_trembles_hides_no_oscillation():
    """Half the amplitude that counts is no turn of the reference."""

    def wanted(t):
        return 0.36e-3 * math.sin(2 * math.pi * 40.0 * t)

    found = run(wanted, lambda t: 1e-3 * math.sin(2 * math.pi * 4.4 * t) - wanted(t), 5.0)
    assert found is not None
    assert "oscillates" in str(found[1])


def test_swings_that_are_too_far_apart_are_a_drift():
    period = 2.0 * ALARM.slowest * 1.1
    assert run(lambda t: 0.0, lambda t: 2e-3 * math.sin(2 * math.pi * t / period), 30.0) is None
    period = 2.0 * ALARM.slowest * 0.9
    assert run(lambda t: 0.0, lambda t: 2e-3 * math.sin(2 * math.pi * t / period), 30.0) is not None


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


def test_each_rod_is_watched_on_its_own_and_named():
    watched = watch(names=("the rod of ch1", "the rod of ch2"))
    with pytest.raises(SafetyError, match=r"the rod of ch2 oscillates at 8\.0 Hz"):
        for k in range(2000):
            t = k * PERIOD
            swing = 1.2e-3 * math.sin(2 * math.pi * 8.0 * t)
            watched.check((0.0, 1e-3), (0.4 * swing, 1e-3 + swing), t)


def test_what_was_before_is_forgotten_when_nothing_was_controlled():
    watched = watch()
    for k in range(3000):
        t = k * PERIOD
        if k % 400 == 0:
            watched.restart()
        watched.check((0.0,), (1.2e-3 * math.sin(2 * math.pi * 5.0 * t),), t)
    watched.restart()
    watched.check((0.0,), (20e-3,), 10.0)  # where the rig was left: no time has passed


def zigzag(errors, *, wanted=None, times=None, **alarm):
    """Give one error per second to an alarm of 0.25 m and three swings; return what it says."""
    settings = {"amplitude": 0.25, "swings": 3, "slowest": 8.0, "lost": 100.0, **alarm}
    watched = watch(following=10.0, alarm=OscillationAlarm(**settings))
    wanted = wanted or [0.0] * len(errors)
    for k, (goal, error) in enumerate(zip(wanted, errors, strict=True)):
        t = float(k) if times is None else times[k]
        try:
            watched.check((goal,), (goal + error,), t)
        except SafetyError as fault:
            return k, str(fault)
    return None


def test_the_amplitude_itself_is_not_beyond_it():
    assert zigzag([0.0, 0.25] * 20) is None
    assert zigzag([0.25, 0.0] * 20) is None
    assert zigzag([0.0, 0.375] * 20) is not None
    # Back by just the amplitude, on by a little more.
    for side in (-1.0, 1.0):
        stairs = [side * (0.0625 * (k // 2) + 0.3125 * (k % 2)) for k in range(40)]
        assert zigzag(stairs) is None


def test_swings_are_counted_from_the_first_extreme_that_is_left_upwards():
    # 0, 1, 0, 1 … : the first peak only begins the first swing; the last one has to be left.
    assert zigzag([0.0, 1.0] * 10)[0] == 5
    assert zigzag([1.0, 0.0] * 10)[0] == 4


def test_a_swing_of_just_the_kept_share_counts_and_a_smaller_one_does_not():
    assert zigzag([0.0, 1.0, 0.0, 0.7, 0.0, 0.7])[0] == 5
    assert zigzag([0.0, 1.0, 0.0, 0.69, 0.0, 0.69]) is None


def test_the_slowest_swing_counts_and_a_slower_one_does_not():
    times = [0.0, 8.0, 16.0, 24.0, 32.0, 40.0]
    assert zigzag([0.0, 1.0] * 3, times=times)[0] == 5
    times[3] += 0.5
    assert zigzag([0.0, 1.0] * 3, times=times) is None


def test_the_frequency_is_that_of_the_swings_that_were_counted():
    _, said = zigzag([0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0])
    assert "oscillates at 0.3 Hz" in said  # left at 2, 5, 6 and 7 s: three swings in 5 s
    _, said = zigzag([0.0, 1.0] * 3)
    assert "oscillates at 0.5 Hz" in said


def test_one_swing_far_to_both_sides_is_enough_unless_it_dies_away():
    far = {"amplitude": 0.25, "swings": 50, "slowest": 8.0, "lost": 100.0}
    for errors, at in (
        ([0.0, 3.0, -3.0, 0.0], 3),
        ([0.0, -3.0, 3.0, 0.0], 3),
        ([0.0, 2.5, -2.0, 0.0, 0.0], None),  # not farther than following
        ([0.0, 2.0, -3.0, 0.0, 0.0], None),
        ([0.0, 4.0, -2.8, 0.0, 0.0], None),  # just the share that dies away
        ([0.0, -4.0, 2.8, 0.0, 0.0], None),
        ([0.0, 4.0, -2.9, 0.0, 0.0], 3),
        ([1.0, 3.9, 1.0, 3.9, 1.0, 3.9], None),  # on one side
    ):
        watched = watch(following=2.0, alarm=OscillationAlarm(**far))
        found = None
        for k, error in enumerate(errors):
            try:
                watched.check((0.0,), (error,), float(k))
            except SafetyError:
                found = k
                break
        assert found == at, errors


def test_what_had_begun_to_swing_is_why_a_limit_was_exceeded():
    alarm = OscillationAlarm(amplitude=0.25, swings=50, slowest=8.0, lost=100.0)
    watched = watch(following=2.0, alarm=alarm, names=("ch1", "ch2"))
    for k, error in enumerate([0.0, 1.5, -1.5, 0.0]):
        assert watched.suspicion(float(k)) is None
        watched.check((0.0, 0.0), (0.0, error), float(k))
    said = watched.suspicion(3.0)
    assert "ch2 oscillates at 0.5 Hz, 3e+03 mm peak to peak" in said
    assert said.endswith("; unless it was pushed")
    watched.check((0.0, 0.0), (0.0, 1.5), 3.5)
    assert watched.suspicion(3.5) == said, "it has not come back from there"
    watched.check((0.0, 0.0), (0.0, 0.0), 4.0)
    assert "pushed" not in watched.suspicion(4.0)
    for k, error in enumerate([-1.5, 0.0, 1.5, 0.0]):  # now it takes half a second to turn round
        watched.check((0.0, 0.0), (0.0, error), 4.25 + 0.25 * k)
    assert watched.suspicion(5.75) is not None
    assert watched.suspicion(5.78125) is None, "it would have turned round by now"
    small = watch(following=2.0, alarm=alarm)
    for k, error in enumerate([0.0, 1.0, -1.0, 0.0]):
        small.check((0.0,), (error,), float(k))
    assert small.suspicion(3.0) is None


def test_a_swing_is_over_after_the_longest_that_any_may_take():
    alarm = OscillationAlarm(amplitude=0.25, swings=50, slowest=1.25, lost=100.0)
    watched = watch(following=2.0, alarm=alarm)
    for k, error in enumerate([0.0, 1.5, -1.5, 0.0]):
        watched.check((0.0,), (error,), float(k))
    assert watched.suspicion(4.25) is not None
    assert watched.suspicion(4.5) is None


def test_a_reference_that_turns_by_more_than_half_the_amplitude_starts_anew():
    swing = [0.0, 1.0] * 10
    assert zigzag(swing, wanted=[0.0, 0.1875] * 10) is None
    assert zigzag(swing, wanted=[0.0, 0.125] * 10) is not None


def test_the_bounds_themselves_are_allowed_and_named():
    alarm = OscillationAlarm(amplitude=100.0, lost=0.25)
    for side in (-1.0, 1.0):
        watched = watch(following=2.0, alarm=alarm)
        for k in range(20):
            watched.check((0.0,), (side * 2.0,), 0.125 * k)
        for k in range(20, 22):  # a quarter of a second after it was last within
            watched.check((0.0,), (side * 2.5,), 0.125 * k)
        with pytest.raises(LimitExceeded, match=r"outside -2 … 2 m"):
            watched.check((0.0,), (side * 2.5,), 3.0)
    _, said = zigzag([0.0, 1.0] * 5)
    assert said.endswith("[3 swings of more than 250 mm, or one of 10000 mm to either side]")


# What is held, and what moves while chambers fill ---------------------------------------------


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
    watched.check_still(home, (home[0] + away, home[1]))
    bound = sign * FOLLOWING
    with pytest.raises(LimitExceeded, match="way of the rod of ch2 while nothing controls it"):
        watched.check_still(home, (home[0], home[1] + 1.01 * bound))
    with pytest.raises(LimitExceeded) as told:
        watched.check_still((0.0, 0.0), (2.0 * bound, 0.0))
    fault = told.value
    assert (fault.value, fault.lower, fault.upper) == (2.0 * bound, -FOLLOWING, FOLLOWING)
    with pytest.raises(LimitExceeded) as told:
        watched.check_still(home, (home[0] + 2.0 * bound, home[1]))
    assert told.value.value == pytest.approx(2.0 * bound)
    watched.check_still((0.0, 0.0), (bound, -bound))
    # A procedure that follows nothing has a bound of its own.
    watched.check_still((0.0, 0.0), (bound, -bound), most=2.0 * FOLLOWING)
    watched.check_still((0.0, 0.0), (0.5 * bound, 0.0), most=0.5 * FOLLOWING)
    with pytest.raises(LimitExceeded) as told:
        watched.check_still((0.0, 0.0), (0.51 * bound, 0.0), most=0.5 * FOLLOWING)
    assert (told.value.lower, told.value.upper) == (-0.5 * FOLLOWING, 0.5 * FOLLOWING)
