"""Which drive has which joint: each exactly once, whatever the devices' order."""

import random

import pytest
from servo_fakes import FakeServo

from rig.hal import ConfigurationError
from rig.mechanisms.servo.wiring import wire_axes

NAMES = ("a", "b", "c", "d", "e")


@pytest.mark.parametrize("seed", range(10))
def test_each_joint_is_found_where_its_drive_is(seed):
    chance = random.Random(seed)
    offered = chance.sample(NAMES, len(NAMES))
    cut = chance.randrange(len(NAMES) + 1)
    servos = [FakeServo("left", offered[:cut]), FakeServo("right", offered[cut:])]
    order, shares = wire_axes(NAMES, servos)
    assert [offered[k] for k in order] == list(NAMES)
    assert [[NAMES[k] for k in share] for share in shares] == [offered[:cut], offered[cut:]]


@pytest.mark.parametrize(
    ("left", "right", "message"),
    [
        (("a", "x"), ("b",), r"^left: the mechanism has no joint 'x'; it has a, b$"),
        (("a",), ("b", "x"), r"^right: the mechanism has no joint 'x'; it has a, b$"),
        (("a", "b"), ("b",), r"^left: two drives move the joint 'b'$"),
        (("a",), ("b", "b"), r"^right: two drives move the joint 'b'$"),
        (("a",), (), r"^no servo device has the joint 'b'; they have a$"),
        ((), ("b",), r"^no servo device has the joint 'a'; they have b$"),
    ],
)
def test_a_joint_too_many_twice_or_missing_is_refused(left, right, message):
    servos = [FakeServo("left", left), FakeServo("right", right)]
    with pytest.raises(ConfigurationError, match=message):
        wire_axes(("a", "b"), servos)
