"""Regulators and joints that do not follow: how far, for how long, and what is doubted before."""

import math

import pytest

from drivers.cia401.settings import FollowingSettings
from drivers.cia401.stuck import StuckWatch as PressureFollowing
from drivers.servos.following_error import FollowingWatch as AngleFollowing
from rig.hal import DeviceFault

TIME, DEVIATION, RESPONSE, START = 2.0**-3, 50e3, 2.0**-4, 100e3


def regulator(response=RESPONSE):
    watch = PressureFollowing("valves", 0x11, "ch2", FollowingSettings(DEVIATION, TIME, response))
    watch.reset(START, 1.0)
    return watch


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_pressure_may_be_off_by_the_deviation_for_ever(sign):
    watch = regulator()
    for t in range(2, 30):
        watch.check(START, START + sign * DEVIATION, float(t))
    off = START + sign * (DEVIATION + 1.0)
    watch.check(START, off, 29.0 + TIME)
    with pytest.raises(DeviceFault) as caught:
        watch.check(START, off, math.nextafter(29.0 + TIME, 30.0))
    error = caught.value
    assert (error.device, error.node) == ("valves", 0x11)
    assert error.what == (
        "the pressure of ch2 does not follow its setpoint (100000 Pa); regulator stuck, or supply "
        "missing"
    )
    assert error.value == f"{sign * 50001:+.0f} Pa for 0.13 s"
    assert error.bound == "50000 Pa for 0.125 s"


def test_it_has_its_time_from_its_first_reading_and_from_each_good_one():
    watch = regulator()
    watch.check(START, 0.0, 1.0 + TIME)
    watch.check(START, START, 1.5)
    watch.check(START, 0.0, 1.5 + TIME)
    with pytest.raises(DeviceFault):
        watch.check(START, 0.0, 1.5 + 2 * TIME)
    watch.reset(0.0, 9.0)
    watch.check(0.0, 0.0, 9.0)
    assert watch.expected == 0.0


def test_what_is_expected_lags_behind_the_setpoint():
    watch = regulator()
    step = RESPONSE / 4
    for number in range(1, 9):
        watch.check(START + 100e3, watch.expected, 1.0 + number * step)
        # Of what was left, each step of an implicit lag leaves response / (response + step).
        assert watch.expected == pytest.approx(START + 100e3 * (1.0 - 0.8**number))
    expected = watch.expected
    watch.check(0.0, expected, 1.0 + 8 * step)  # no time has passed
    assert watch.expected == expected
    at_once = regulator(response=0.0)
    at_once.check(200e3, 200e3, 1.5)
    assert at_once.expected == 200e3
    at_once.check(0.0, 200e3, 1.5)  # no time has passed
    assert at_once.expected == 200e3


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_half_of_the_deviation_is_enough_for_a_doubt(sign):
    watch = regulator()
    assert watch.doubt() is None
    watch.check(START, START + sign * 0.5 * DEVIATION, 1.5)
    assert watch.doubt() is None
    watch.check(START, START + sign * (0.5 * DEVIATION + 1.0), 2.0)
    assert watch.doubt() == (
        25001.0,
        f"the pressure of ch2 is {sign * 25.001:+.0f} kPa off what its setpoint asks for: its "
        "regulator may be stuck",
    )
    watch.reset(START, 3.0)
    assert watch.doubt() is None


def test_a_watch_that_has_seen_nothing_doubts_nothing():
    watch = PressureFollowing("valves", 0x11, "ch2", FollowingSettings(1.0, TIME, RESPONSE))
    assert (watch.doubt(), watch.expected) == (None, 0.0)
    watch.check(0.0, 9.0, TIME)  # it has been well since 0
    watch.reset(START, 1.0)
    assert watch.doubt() is None
    fresh = AngleFollowing(WINDOW, TIME)
    assert (fresh.reference, fresh.error) == (0.0, 0.0)
    assert fresh.exceeds(1.0, TIME) == 0.0 < fresh.exceeds(1.0, 2.0 * TIME)


# Joints on servo drives --------------------------------------------------------------------

WINDOW = 2.0**-3


def joint():
    watch = AngleFollowing(WINDOW, TIME)
    watch.reset(1.0, 1.0)
    return watch


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_may_be_off_by_the_window_for_ever(sign):
    watch = joint()
    for t in range(2, 30):
        assert watch.exceeds(1.0 + sign * WINDOW, float(t)) == 0.0
    off = 1.0 + sign * (WINDOW + 2.0**-40)
    assert watch.exceeds(off, 29.0 + TIME) == 0.0
    assert watch.error == -sign * (WINDOW + 2.0**-40)
    late = math.nextafter(29.0 + TIME, 30.0)
    assert watch.exceeds(off, late) == late - 29.0


def test_a_joint_has_its_time_from_where_it_started_and_from_each_good_reading():
    watch = joint()
    assert watch.exceeds(9.0, 1.0 + TIME) == 0.0
    assert watch.exceeds(1.0, 1.5) == 0.0
    assert watch.exceeds(9.0, 1.5 + TIME) == 0.0
    assert watch.exceeds(9.0, 1.5 + 2.0 * TIME) == 2.0 * TIME
    watch.reset(9.0, 7.0)
    assert (watch.reference, watch.error) == (9.0, 0.0)
    assert watch.exceeds(0.0, 7.0 + TIME) == 0.0


def test_a_drifting_reference_goes_with_the_velocity_and_forgets_its_distance():
    watch = joint()
    watch.drift(2.0, 1.0, TIME)  # a period as long as the time: half of the distance is left
    assert watch.reference == 1.0 + 0.5 * 2.0 * TIME
    watch = joint()
    for _ in range(800):
        watch.drift(0.0, 2.0, TIME / 100)
    assert watch.reference == pytest.approx(2.0 - math.exp(-8.0), rel=0.05, abs=1e-3)
    watch = joint()
    watch.drift(0.0, 2.0, TIME / 4)
    assert watch.reference == 1.0 + 0.2
