"""Which joint of a chain of drives is doubted when the rig gets out of bounds."""

from types import SimpleNamespace

import pytest

from drivers.servos.axis_chain import ServoChain
from drivers.servos.axis_settings import AxisSettings
from drivers.servos.following_error import FollowingWatch
from rig.hal import DeviceFault

WINDOW = 0.25


class FakeDrive:
    """A drive that is enabled at once and stands where a test says."""

    velocity = torque = time = 0.0
    is_enabled = True

    def __init__(self, name, window):
        self.name = name
        self.settings = AxisSettings()
        self.watch = FollowingWatch(window, 1.0)
        self.position = 0.0

    def enable(self, enabled):
        pass

    def step(self):
        pass

    def begin_following(self, now):
        self.watch.reset(self.position, now)

    def command_position(self, position, velocity):
        self.watch.reference = position

    def command_velocity(self, velocity):
        raise AssertionError("these follow positions")

    def stop(self):
        pass

    def watch_stop(self):
        pass

    def check(self, now):
        pass

    def check_following(self, now):
        self.watch.exceeds(self.position, now)

    def lag(self):
        return DeviceFault("arm", f"{self.name} is not where its reference is")

    def fail_to_enable(self, since):
        return DeviceFault("arm", f"{self.name} is not enabled")


class Chain(ServoChain):
    """The part of a driver that a chain does not have."""

    def connect(self):
        pass

    def arm(self):
        self._armed = True

    def close(self):
        pass


def chain_of(*windows):
    drives = [FakeDrive(f"q{k}", window) for k, window in enumerate(windows)]
    joints = {drive.name: drive.settings for drive in drives}
    settings = SimpleNamespace(joints=joints, position_gain=1.0, enable_time=1.0)
    chain = Chain("arm", settings, drives, period=1.0, sends_velocity=False)
    chain.arm()
    chain.set_torque_enabled(True)
    chain.check(0.0)
    assert chain.is_enabled
    return chain


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_is_doubted_beyond_its_window(sign):
    chain = chain_of(WINDOW, WINDOW)
    _, drive = chain.drives
    drive.position = sign * WINDOW
    chain.check(0.1)
    assert chain.doubt(0.1) is None
    drive.position = sign * (WINDOW + 2.0**-40)
    chain.check(0.2)
    assert chain.doubt(0.2) == "arm: q1 is not where its reference is"


def test_the_joint_that_is_furthest_beyond_its_own_window_is_doubted():
    chain = chain_of(1.0, 0.25, 0.5)
    for drive, position in zip(chain.drives, (1.25, -0.75, 0.875), strict=True):
        drive.position = position
    chain.check(0.1)
    assert chain.doubt(0.1) == "arm: q1 is not where its reference is"
    chain.drives[0].position = 0.9  # the largest error, and within its window
    chain.drives[1].position = 0.0
    chain.check(0.2)
    assert chain.doubt(0.2) == "arm: q2 is not where its reference is"


def test_a_chain_that_is_not_enabled_is_not_doubted():
    chain = chain_of(WINDOW)
    chain.drives[0].position = 9.0
    chain.check(0.1)
    chain.make_safe()
    assert chain.doubt(0.1) is None
