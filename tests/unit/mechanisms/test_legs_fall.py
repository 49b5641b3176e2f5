"""A fall is seen by two sensors together; either of them alone may lie."""

import math

import pytest

from controllers.gait.sensing import FootLoad, Sensing
from rig.hal import SafetyError
from rig.mechanisms.legs.fall import FallWatch

PERIOD, WEIGHT = 0.005, 58.8
BOUND = math.radians(30.0)
LASTS, LIFTED = 10, 60
"""Periods in 50 ms, in 300 ms."""


def felt(lean, borne, axis=0):
    loads = (FootLoad(0.25 * borne, (0.0, 0.0)), FootLoad(0.75 * borne, (0.0, 0.0)))
    leans = (math.radians(lean), 0.0) if axis == 0 else (0.0, math.radians(lean))
    return Sensing(loads, leans, (0.0, 0.0))


def watch(bound=BOUND, period=PERIOD):
    return FallWatch(bound, WEIGHT, period)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_robot_that_leans_without_load_has_fallen_after_50_ms(axis, sign):
    its = watch()
    for _ in range(LASTS - 1):
        its.see(felt(sign * 30.1, 0.49 * WEIGHT, axis))
    assert not its.has_fallen
    told = (
        r"bear 28\.8 N of .* 58\.8 N.* leans by 30\.1 deg, the limit is 30 deg \(legs\.fall_tilt\)"
    )
    with pytest.raises(SafetyError, match=told):
        its.see(felt(sign * 30.1, 0.49 * WEIGHT, axis))
    assert its.has_fallen


@pytest.mark.parametrize(("lean", "share"), [(29.9, 0.0), (90.0, 0.5), (90.0, 1.0), (0.0, 0.0)])
def test_one_sensor_alone_stops_nobody(lean, share):
    its = watch()
    for _ in range(200):
        its.see(felt(lean, share * WEIGHT))
    assert not its.has_fallen


def test_a_lean_of_just_the_bound_is_borne():
    its = watch(bound=math.radians(45.0))
    for _ in range(200):
        its.see(felt(45.0, 0.0))
    assert not its.has_fallen


def test_a_moment_on_the_feet_begins_the_time_anew():
    its = watch()
    for _ in range(20):
        for _ in range(LASTS - 1):
            its.see(felt(45.0, 0.0))
        its.see(felt(45.0, WEIGHT))
    assert not its.has_fallen


@pytest.mark.parametrize("lean", [0.0, 20.0])
def test_a_robot_that_stood_and_stands_no_more_is_stopped_after_300_ms(lean):
    its = watch()
    its.see(felt(0.0, 0.5 * WEIGHT))
    for _ in range(LIFTED - 1):
        its.see(felt(lean, 0.099 * WEIGHT))
    assert not its.has_fallen
    with pytest.raises(SafetyError, match=r"falls, lies or is lifted: its feet bear 5\.82 N"):
        its.see(felt(lean, 0.099 * WEIGHT))
    assert its.has_fallen


@pytest.mark.parametrize("share", [0.1, 0.4])
def test_cells_that_show_less_stop_nobody(share):
    its = watch()
    its.see(felt(0.0, WEIGHT))
    for _ in range(200):
        its.see(felt(0.0, share * WEIGHT))
    assert not its.has_fallen


def test_who_stands_in_between_has_all_the_time_again():
    its = watch()
    for _ in range(20):
        its.see(felt(0.0, WEIGHT))
        for _ in range(LIFTED - 1):
            its.see(felt(0.0, 0.0))
    assert not its.has_fallen


def test_a_robot_that_is_not_watched_may_lie():
    its = watch(bound=None)
    its.see(felt(0.0, WEIGHT))
    for _ in range(200):
        its.see(felt(170.0, 0.0))


def test_a_slow_loop_sees_who_left_its_feet_in_its_first_cycle():
    its = watch(period=1.0)
    its.see(felt(0.0, WEIGHT))
    with pytest.raises(SafetyError):
        its.see(felt(0.0, 0.0))


def test_a_slow_loop_sees_it_in_its_first_cycle():
    with pytest.raises(SafetyError):
        watch(period=0.2).see(felt(45.0, 0.0))
