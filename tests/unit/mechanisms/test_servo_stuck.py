"""A joint that is sent away and does not go, and those that are late, sag, or turn round."""

import math

import numpy as np
import pytest

from rig.hal import LimitExceeded
from rig.mechanisms.servo.stuck import StandstillWatch

PERIOD, MOST = 0.005, 0.05


class Joints:
    """Two joints: `b` follows at once; where `a` is a test says."""

    def __init__(self, start=0.3):
        self.watch = StandstillWatch(("a", "b"), MOST)
        self.watch.begin((start, 0.0))
        self.sent, self.cycles = start, 0

    def go(self, sent, here, age=0.0):
        speed = (sent - self.sent) / PERIOD
        self.sent = sent
        self.watch.check((here, sent), (sent, sent), (speed, speed), age)
        self.cycles += 1


def moves(speed, seconds, start=0.3):
    return start + speed * PERIOD * np.arange(1, round(seconds / PERIOD) + 1)


@pytest.mark.parametrize("speed", [0.2, -0.2, 0.02, 2.0])
def test_a_joint_that_stays_is_named_once_it_was_sent_too_far(speed):
    joints = Joints()
    with pytest.raises(LimitExceeded, match="way that a was sent and does not go") as caught:
        for sent in moves(speed, 10.0):
            joints.go(sent, 0.3)
    most = MOST + 0.05 * abs(speed)
    assert caught.value.value == pytest.approx(most, abs=abs(speed) * PERIOD)
    assert caught.value.upper == pytest.approx(most)


def test_one_that_is_pushed_the_other_way_is_seen_sooner():
    joints = Joints()
    with pytest.raises(LimitExceeded):
        for sent in moves(0.2, 10.0):
            joints.go(sent, 0.3 - (sent - 0.3))
    assert abs(joints.sent - 0.3) == pytest.approx(0.5 * (MOST + 0.05 * 0.2), abs=2e-3)


@pytest.mark.parametrize("delay", [0, 2, 5])
@pytest.mark.parametrize("speed", [0.05, 1.0, 4.7])
def test_one_that_is_late_by_25_ms_is_well(delay, speed):
    joints = Joints()
    way = moves(speed, 3.0)
    turned = np.concatenate((way, way[::-1], way, np.full(200, way[-1])))
    late = np.concatenate((np.full(delay, 0.3), turned))
    for sent, here in zip(turned, late, strict=False):
        joints.go(sent, here)


def test_old_readings_are_late_too():
    way = moves(4.0, 1.0)
    late = np.concatenate((np.full(14, 0.3), way))
    joints = Joints()
    for sent, here in zip(way, late, strict=False):
        joints.go(sent, here, age=0.02)
    joints = Joints()
    with pytest.raises(LimitExceeded):
        for sent, here in zip(way, late, strict=False):
            joints.go(sent, here)


@pytest.mark.parametrize("share", [0.26, 0.5, 1.0])
def test_one_that_goes_by_a_quarter_of_its_way_is_not_stuck(share):
    joints = Joints()
    for sent in moves(0.2, 10.0):
        joints.go(sent, 0.3 + share * (sent - 0.3))


def test_one_that_sags_by_less_while_it_is_hardly_sent_is_well():
    joints = Joints()
    for k in range(1, 400):
        joints.go(0.3 + 0.02 * math.sin(0.03 * k), 0.3 - 0.028 * math.sin(0.03 * k))


def test_a_joint_that_followed_has_its_whole_way_again():
    joints = Joints()
    for sent in moves(0.2, 1.0):
        joints.go(sent, sent)
    here = joints.sent
    with pytest.raises(LimitExceeded):
        for sent in moves(-0.2, 1.0, here):
            joints.go(sent, here)
    assert here - joints.sent == pytest.approx(MOST + 0.01, abs=0.01)


def test_what_is_left_of_the_way_may_be_the_bound_and_is_told_beyond_it():
    watch = StandstillWatch(("a",), 0.5)
    watch.begin((1.0,))
    watch.check((0.875,), (1.375,), (0.0,), 0.0)
    with pytest.raises(LimitExceeded) as caught:
        watch.check((0.8125,), (1.375,), (0.0,), 0.0)
    its = caught.value
    assert (its.value, its.lower, its.upper) == (0.5625, 0.0, 0.5)


def test_from_a_quarter_of_its_way_on_a_joint_begins_anew():
    watch = StandstillWatch(("a",), 0.5)
    watch.begin((0.0,))
    watch.check((0.125,), (0.5,), (0.0,), 0.0)
    watch.check((0.125,), (1.0,), (0.0,), 0.0)


def test_a_way_of_a_tenth_tells_nothing():
    watch = StandstillWatch(("a",), 0.5)
    watch.begin((0.0,))
    watch.check((0.05,), (0.05,), (0.0,), 0.0)  # it may have come along by chance
    with pytest.raises(LimitExceeded) as caught:
        watch.check((0.0,), (0.5625,), (0.0,), 0.0)
    assert caught.value.value == 0.5625


def test_nobody_has_to_say_where_it_begins():
    watch = StandstillWatch(("a",), 0.5)
    watch.check((1.0,), (1.0,), (0.0,), 0.0)
    watch.check((1.0,), (1.5,), (0.0,), 0.0)
    with pytest.raises(LimitExceeded):
        watch.check((1.0,), (1.5625,), (0.0,), 0.0)
