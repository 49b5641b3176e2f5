"""A fall is seen by two sensors together; either of them alone may lie."""

import math

import pytest

from controllers.gait.sensing import FootLoad, Sensing
from rig.hal import SafetyError
from rig.mechanisms.legs.fall import FallWatch

PERIOD, WEIGHT = 0.005, 58.8
BOUND = math.radians(30.0)
LASTS = 10
"""Periods in 50 ms."""


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
        r"leans by 30\.1 deg, the limit is 30 deg \(legs\.fall_tilt\), .* bear 28\.8 N of .* 58\.8"
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


def test_a_robot_that_is_not_watched_may_lie():
    its = watch(bound=None)
    for _ in range(200):
        its.see(felt(170.0, 0.0))


def test_a_slow_loop_sees_it_in_its_first_cycle():
    with pytest.raises(SafetyError):
        watch(period=0.2).see(felt(45.0, 0.0))
