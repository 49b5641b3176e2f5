"""Camera against encoders, and the ring's twist: distances, graces, and who is to blame."""

import math

import pytest
from joint_fakes import ENCODERS, GRACE

from controllers.spherical_joint.types import CameraSample
from rig.hal import SafetyError
from rig.mechanisms.joint.alarms.camera import MarkerWatch
from rig.mechanisms.joint.alarms.settings import TwistAlarm

LIMIT = 2.0**-8
TINY = 2.0**-40
CYCLE, FRAME = 2.0**-8, 2.0**-6
TOP = (0.0, 0.0, 2.0**-4)
TWIST = TwistAlarm(0.25, 2.0**-4)


def new_watch(limit=LIMIT, grace=GRACE):
    return MarkerWatch("camera", limit, grace, TWIST, ENCODERS)


def see(watch, t, encoders, camera):
    watch.take(encoders, t)
    watch.check(CameraSample(camera, t))


def beside(distance, of=TOP):
    return (of[0] + distance, of[1], of[2])


def test_the_marker_may_be_off_by_the_limit_for_ever():
    watch = new_watch()
    for k in range(50):
        see(watch, k * FRAME, TOP, beside(LIMIT))


def test_a_marker_further_off_has_its_grace_and_not_more():
    watch = new_watch()
    for t in (1.0, 1.0 + 0.5 * GRACE, 1.0 + GRACE):
        see(watch, t, TOP, beside(LIMIT + TINY))  # the first one counts as seen alike
    with pytest.raises(SafetyError) as caught:
        see(watch, 1.0 + GRACE + TINY, TOP, beside(LIMIT + TINY))
    assert str(caught.value) == (
        "camera: it is not where the joint is calibrated to be before anything has moved: another "
        "rig's calibration, a moved camera or another marker [the marker is 3.9 mm from where the "
        "encoders put it for 0.031 s, at most 3.90625 mm for 0.03125 s]"
    )


def test_each_sample_that_agrees_gives_the_grace_again():
    watch = new_watch()
    for k in range(20):
        see(watch, 2 * k * GRACE, TOP, beside(LIMIT))
        see(watch, (2 * k + 1) * GRACE, TOP, beside(2 * LIMIT))
    with pytest.raises(SafetyError):
        see(watch, 40 * GRACE, TOP, beside(2 * LIMIT))


def test_a_sample_is_judged_once():
    watch = new_watch()
    see(watch, 0.0, TOP, TOP)
    late = CameraSample(beside(9 * LIMIT), GRACE)
    watch.check(late)
    watch.take(beside(18 * LIMIT), 2 * GRACE)
    watch.check(late)  # it would agree now
    with pytest.raises(SafetyError):
        watch.check(CameraSample(TOP, 2 * GRACE))


def test_a_sample_older_than_the_last_one_takes_no_grace_away():
    watch = new_watch()
    see(watch, 0.0, TOP, TOP)
    see(watch, GRACE, TOP, TOP)
    watch.check(CameraSample(TOP, 0.5 * GRACE))
    see(watch, 2 * GRACE, TOP, beside(9 * LIMIT))


def along(limits):
    """Return a place so many limits along a diagonal."""
    share = limits * LIMIT / math.sqrt(3.0)
    return (share, -share, TOP[2] + share)


@pytest.mark.parametrize(
    ("cycles", "limits"),
    [(0.5, 0.5), (1.0, 1.0), (1.25, 1.75), (1.5, 2.5), (1.75, 3.25), (2.0, 4.0), (9.0, 4.0)],
)
@pytest.mark.parametrize("error", [0.99, -0.99, 1.01, -1.01])
def test_a_sample_is_compared_with_the_pose_at_its_exposure(cycles, limits, error):
    watch = new_watch(grace=0.0)
    for number, place in enumerate((0.0, 1.0, 4.0)):
        watch.take(along(place), number * CYCLE)
    watch.check(CameraSample(along(0.0), 0.0))
    sample = CameraSample(along(limits + error), cycles * CYCLE)
    if abs(error) < 1.0:
        watch.check(sample)
        return
    with pytest.raises(SafetyError):
        watch.check(sample)


def test_samples_from_before_what_is_remembered_are_not_compared():
    watch = new_watch(grace=0.0)
    watch.check(CameraSample(TOP, -1.0))  # nothing is remembered at all
    for number in range(257):
        watch.take(TOP, number * CYCLE)
    watch.check(CameraSample(TOP, CYCLE))
    watch = new_watch(grace=0.0)
    for number in range(257):
        watch.take(TOP, number * CYCLE)
    for t in (0.0, 0.5 * CYCLE):
        watch.check(CameraSample(beside(9 * LIMIT), t))
    watch.check(CameraSample(TOP, CYCLE))
    with pytest.raises(SafetyError):
        watch.check(CameraSample(beside(9 * LIMIT), 1.5 * CYCLE))


def blame(encoders, camera, start=None):
    """Return what is said of a marker seen elsewhere for too long; the ring came from a start."""
    watch = new_watch()
    watch.take(encoders if start is None else start, -CYCLE)
    see(watch, 0.0, encoders, camera)
    with pytest.raises(SafetyError) as caught:
        see(watch, 2.0 * GRACE, encoders, camera)
    return str(caught.value)


LEANING = (5 * LIMIT, 3 * LIMIT, 2.0**-4)


def test_before_the_marker_has_moved_by_three_limits_nothing_has_moved():
    camera = (-LEANING[0], LEANING[1], LEANING[2])
    x, y, z = LEANING
    assert "before anything has moved" in blame(LEANING, camera, (x, y - 3.0 * LIMIT, z))
    assert "left to right" in blame(LEANING, camera, (x, y - 3.0 * LIMIT - TINY, z))


@pytest.mark.parametrize(
    ("camera", "what"),
    [
        (lambda x, y, z: (-x, y, z), "the image is mirrored left to right"),
        (lambda x, y, z: (x, -y, z), "the image is mirrored top to bottom"),
        (lambda x, y, z: (-x, -y, z), "the image is upside down"),
        (lambda x, y, z: (-y, x, z), "the image is turned by a quarter"),
        (lambda x, y, z: (y, -x, z), "the image is turned by a quarter"),
        (lambda x, y, z: (y, x, z), "another marker is followed, the camera was moved, an"),
    ],
)
def test_once_it_has_moved_a_wrong_image_is_told_by_its_place(camera, what):
    assert what in blame(LEANING, camera(*LEANING), TOP)


@pytest.mark.parametrize(
    ("short", "what"), [(TINY, "mirrored left to right"), (0.0, "another marker is followed")]
)
def test_a_wrong_image_explains_the_camera_within_the_limit(short, what):
    x, y, z = LEANING
    assert what in blame(LEANING, (-x, y, z + LIMIT - short), TOP)


@pytest.mark.parametrize(
    ("camera", "names"),
    [
        (lambda x, y, z: (x, -y, z), "e1 and e3 are swapped, or the image is mirrored"),
        (lambda x, y, z: (-x, y, z), "e2 and e4 are swapped, or the image is mirrored"),
        (lambda x, y, z: (-x, -y, z), "e1 and e3, and e2 and e4, are swapped, or the image"),
    ],
)
def test_opposite_encoders_that_are_swapped_mirror_the_pose(camera, names):
    x, y, z = camera(*LEANING)
    assert names in blame(LEANING, (x, y, z))
    assert names in blame(LEANING, (x, y, z + LIMIT - TINY))
    assert "another rig's calibration" in blame(LEANING, (x, y, z + LIMIT))


@pytest.mark.parametrize(("left", "swapped"), [(0.59, True), (0.61, False)])
def test_near_upright_the_mirrored_place_must_be_less_than_half_as_far(left, swapped):
    encoders = (0.0, 0.3 * LIMIT, 2.0**-4)
    said = blame(encoders, (0.0, -(0.3 + left) * LIMIT, 2.0**-4))
    assert ("e1 and e3 are swapped" in said) is swapped


# Twist ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_ring_may_be_twisted_by_the_limit_for_ever(sign):
    watch = new_watch()
    for k in range(50):
        watch.check_twist(sign * TWIST.limit, k * FRAME)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_ring_twisted_from_the_start_has_its_time_as_well(sign):
    watch = new_watch()
    twist = sign * (TWIST.limit + TINY)
    watch.check_twist(twist, 1.0)  # the first one counts as straight
    watch.check_twist(twist, 1.0 + TWIST.time)
    with pytest.raises(SafetyError):
        watch.check_twist(twist, 1.0 + TWIST.time + TINY)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_ring_twisted_further_has_its_time_and_not_more(sign):
    watch = new_watch()
    twist = sign * (TWIST.limit + TINY)
    for t in (1.0, 2.0, 3.0):
        watch.check_twist(sign * TWIST.limit, t)
        watch.check_twist(twist, t + TWIST.time)
    watch.check_twist(0.0, 4.0)
    watch.check_twist(twist, 4.0 + TWIST.time)
    with pytest.raises(SafetyError) as caught:
        watch.check_twist(twist, 4.0 + TWIST.time + TINY)
    assert str(caught.value) == (
        "camera: the ring is twisted, or the marker is mounted so [twist "
        f"{'+' if sign > 0 else '-'}14.3 deg for 0.063 s, at most 14.3239 deg either way for "
        "0.0625 s]"
    )
