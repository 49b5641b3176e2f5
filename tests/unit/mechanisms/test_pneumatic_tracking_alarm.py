"""A rod that swings about its reference, on drawn motions."""

import math
import re

import numpy as np
import pytest

from rig.hal import LimitExceeded, SafetyError
from rig.mechanisms.pneumatic.alarms.settings import OscillationAlarm
from rig.mechanisms.pneumatic.alarms.tracking import TrackingWatch

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


@pytest.mark.parametrize(
    ("swings", "errors", "pushed"),
    [
        (50, [0.0, 3.0, -3.0, 0.0], True),
        (50, [0.0, -3.0, 3.0, 0.0], True),
        (3, [0.0, 1.5, -1.5, 1.5, -1.5, 0.0], False),
        (2, [0.0, 0.5, -0.9, 1.4, 0.0], False),  # it has lasted, and grows
        # What was nearer before is no swing yet: a push may have thrown it to the first end.
        (50, [0.0, 1.0, -3.0, 2.8, 0.0], True),
        (50, [0.0, -1.0, 3.0, -2.8, 0.0], True),
        (50, [0.0, 1.99, -2.9, 2.8, 0.0], False),
        (50, [0.0, -1.99, 2.9, -2.8, 0.0], False),
        (50, [0.0, 0.7 * 2.8, -2.9, 2.8, 0.0], False),
    ],
)
def test_a_single_swing_is_named_with_the_push_that_may_have_begun_it(swings, errors, pushed):
    alarm = OscillationAlarm(amplitude=0.25, swings=swings, slowest=8.0, lost=100.0)
    watched = watch(following=2.0, alarm=alarm)

    def take_all():
        for k, error in enumerate(errors):
            watched.check((0.0,), (error,), float(k))

    with pytest.raises(SafetyError, match="oscillates at") as caught:
        take_all()
    assert ("; unless it was pushed [" in str(caught.value)) == pushed


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


def stepped(size, swing=0.0):
    """Return what raised while a reference stepped at 0.5 s and the rod overshot by a share."""
    place = 0.0

    def error(t):
        nonlocal place
        late = t - 0.5
        if late < 0.0:
            return 0.0
        place = size * (1.0 - math.exp(-late / 0.02)) + swing * math.sin(2.0 * math.pi * 5.0 * late)
        return place - size

    watched = watch()
    return run(lambda t: size * (t >= 0.5), error, 1.6, watched), watched


@pytest.mark.parametrize("size", [18e-3, -10e-3, 4e-3])
def test_what_a_step_leaves_behind_is_no_swing_but_what_goes_on_is_one(size):
    assert stepped(size)[0] is None
    assert stepped(size, 2e-3)[0] is not None, "it goes on to swing"
    watched = watch()
    watched.check((0.0,), (0.0,), 0.0)
    for t, error in ((0.01, -size), (0.03, 0.3 * size), (0.05, 0.0)):
        watched.check((size,), (size + error,), t)  # it overshoots by a third, and comes back
    assert "oscillates" not in watched.suspicion(0.05)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_what_swings_after_a_step_is_counted_from_there_on_either_side(side):
    """Six swings of 2 mm in all, of which the first four were before it."""
    said = []
    for steps in (0.0, 8e-3):
        watched, found = watch(), None
        for k, error in enumerate([0.0, *[2e-3, -2e-3] * 8]):
            goal = side * steps * (k >= 5)
            try:
                watched.check((goal,), (goal + side * error,), 0.125 * k)
            except SafetyError:
                found = found or k
        said.append(found)
    before, after = said
    assert after == 13 > before + 4


def test_a_limit_that_is_exceeded_right_after_a_step_is_told_with_it():
    alarm = OscillationAlarm(amplitude=1.5e-3, swings=6, slowest=1.0, lost=0.25)
    watched = watch(names=("ch1", "ch2"), alarm=alarm)
    watched.check((0.0, 0.0), (0.0, 0.0), 1.0 - 2.0**-10)
    watched.check((0.0, -18e-3), (0.0, 0.0), 1.0)
    for later in (0.0, 0.25):
        said = watched.suspicion(1.0 + later)
        assert said == "ch2 follows a step of its reference by -18 mm"
    assert watched.suspicion(1.25 + 2.0**-20) is None
    smooth = watch()
    for k in range(100):
        smooth.check((0.7e-3 * k,), (0.7e-3 * k,), PERIOD * k)
    assert smooth.suspicion(0.1) is None
