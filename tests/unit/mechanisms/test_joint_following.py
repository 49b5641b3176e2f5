"""Rods that follow a controller, are left alone by a procedure, or are nobody's."""

import pytest
from joint_fakes import UPRIGHT, joint_settings, off

from controllers.spherical_joint.types import JointEstimate
from rig.hal import LimitExceeded, SafetyError
from rig.mechanisms.joint.following import RodsFollow

ZERO = (0.0, 0.0, 0.0)
LED = JointEstimate(ZERO, ZERO, 0.0, UPRIGHT, (0.0,) * 4)
PUSHED = LED._replace(push=(0.0, 20.0))
SETTINGS = joint_settings()
FOLLOWING = min(SETTINGS.limits.following, SETTINGS.sway)


def nobody_knows():
    return None


def nobody_drives(rod, off):
    return False


def follow(watched, estimate, rods, now, held=nobody_knows, driven=nobody_drives):
    watched.check(estimate, rods, now, held, driven)


def test_a_led_rod_must_follow_and_one_that_nobody_leads_need_not():
    far = off(UPRIGHT, 2, 2.5 * SETTINGS.limits.following)
    for estimate in (None, LED._replace(push=(1.0, 1.0))):
        watched = RodsFollow(SETTINGS)
        follow(watched, estimate, UPRIGHT, 0.0)
        follow(watched, estimate, far, 0.001)
    watched = RodsFollow(SETTINGS)
    follow(watched, LED, UPRIGHT, 0.0)
    with pytest.raises(LimitExceeded, match="following error of the rod of ch2"):
        follow(watched, LED, far, 0.001)


def test_what_was_is_forgotten_where_nothing_is_controlled():
    far = off(UPRIGHT, 2, 2.5 * SETTINGS.limits.following)
    for between in (None, PUSHED, "restart"):
        watched = RodsFollow(SETTINGS)
        follow(watched, LED, UPRIGHT, 0.0)
        if between == "restart":
            watched.restart()
        else:
            follow(watched, between, far, 0.001)
        follow(watched, LED, far, 0.002)


def test_who_is_held_is_asked_for():
    watched = RodsFollow(SETTINGS)
    far = off(UPRIGHT, 2, 1.01 * SETTINGS.limits.following)
    follow(watched, LED, UPRIGHT, 0.0)
    with pytest.raises(SafetyError, match="a chamber leaks"):
        follow(watched, LED, far, 0.1, lambda: "a chamber leaks")


@pytest.mark.parametrize("leave", ["controller", "none", "restart", "stay"])
def test_a_pair_that_nothing_pushes_stands_as_long_as_the_other_is_pushed(leave):
    watched = RodsFollow(SETTINGS)
    for k in range(300):
        follow(watched, PUSHED, UPRIGHT, k * 1e-3)
    gone = off(off(UPRIGHT, 1, 1.01 * FOLLOWING), 3, -1.01 * FOLLOWING)
    if leave == "stay":
        with pytest.raises(LimitExceeded, match="way of the pair ch1, ch3 that nothing pushes"):
            follow(watched, PUSHED, gone, 0.3)
        return
    if leave == "restart":
        watched.restart()
    else:
        follow(watched, LED if leave == "controller" else None, UPRIGHT, 0.3)
    follow(watched, PUSHED, gone, 0.301)


def test_who_drives_a_rod_is_asked_for():
    watched, asked = RodsFollow(SETTINGS), []
    far = off(UPRIGHT, 2, 2.5 * SETTINGS.limits.following)
    follow(watched, LED, UPRIGHT, 0.0)
    follow(watched, LED, far, 0.001, driven=lambda rod, off: asked.append(rod) or True)
    assert asked == [1]


def test_nothing_moves_while_chambers_fill_and_a_swing_is_suspected():
    watched = RodsFollow(SETTINGS)
    watched.check_still(UPRIGHT, off(UPRIGHT, 4, FOLLOWING), 0.0)
    with pytest.raises(LimitExceeded, match="way of the rod of ch4 while nothing controls it"):
        watched.check_still(UPRIGHT, off(UPRIGHT, 4, 1.001 * FOLLOWING), 1.0)
    assert watched.suspicion(0.0) is None
    size = 1.5 * SETTINGS.alarms.oscillation.amplitude
    for k, error in enumerate((0.0, 0.5, -0.5, 0.5, -0.5, 0.0)):
        follow(watched, LED, off(UPRIGHT, 1, error * size), 0.05 * k)
    assert "the rod of ch1 oscillates" in (watched.suspicion(0.25) or "")
