"""An ODrive axis that reboots at any moment between its first heartbeat and the closed loop.

It runs on its defaults then: no watchdog, other limits. Either they are put right, or the axis is
named before anything moves.
"""

import random

import pytest
from servo_bench import odrive_rig

from drivers.odrive.settings import OdriveEndpoints
from rig.hal import DeviceError

ALL = OdriveEndpoints(
    enable_watchdog=300, watchdog_timeout=301, heartbeat_period=400, encoder_period=401,
    speed_limit=500, current_limit=501,
)  # fmt: skip
WATCHDOG = 0.04
SAVED = ("watchdog_timeout", "enable_watchdog", "heartbeat_msg_rate_ms", "encoder_msg_rate_ms")


def start(rig, axis, at):
    """Start the rig, with a reboot of an axis at an instant, s; return what was said of it."""
    world, advance = rig.rig, rig.rig.advance
    rebooted = []

    def with_reboot(t):
        if not rebooted and at <= t:
            advance(max(at, world.time))
            rig.inject(f"arm.q{axis + 1}", "reboot")
            rebooted.append(True)
        advance(t)

    world.advance = with_reboot
    try:
        rig.start(cycles=400)
    except DeviceError as error:
        return str(error), bool(rebooted)
    return None, bool(rebooted)


def duration(endpoints):
    rig = odrive_rig(endpoints=endpoints, watchdog=WATCHDOG)
    rig.start()
    return rig.clock.now()


def check_limits(rig, axis):
    node, joint = rig.side.nodes[axis], list(rig.driver.settings.joints.values())[axis]
    assert node.speed_limit == pytest.approx(joint.motor_speed_limit)
    assert node.current_limit == pytest.approx(joint.current_limit)


@pytest.mark.parametrize("seed", range(16))
def test_with_its_endpoints_it_is_named_or_as_it_was_told(seed):
    chance = random.Random(seed)
    rig = odrive_rig(endpoints=ALL, watchdog=WATCHDOG)
    axis = chance.randrange(2)
    said, rebooted = start(rig, axis, chance.uniform(0.0, duration(ALL)))
    assert rebooted
    if said is None:
        check_limits(rig, axis)
        node = rig.side.nodes[axis]
        assert node.enable_watchdog
        assert node.watchdog_timeout == pytest.approx(WATCHDOG)
    else:
        assert f"joint q{axis + 1}" in said


def test_one_that_lost_its_watchdog_after_it_was_configured_is_named():
    rig = odrive_rig(endpoints=ALL, watchdog=WATCHDOG)
    rig.open()
    for name, value in zip(SAVED, (0.0, False, 20, 5), strict=True):
        setattr(rig.side.nodes[1], name, value)
    rig.driver.arm()
    with pytest.raises(DeviceError, match=r"joint q2 .*lost its settings; it rebooted.*watchdog"):
        rig.run(100)
    assert not rig.driver.is_enabled


@pytest.mark.parametrize("seed", range(16))
def test_without_endpoints_its_limits_are_those_that_it_was_told(seed):
    chance = random.Random(seed)
    rig = odrive_rig(watchdog=WATCHDOG)
    axis = chance.randrange(2)
    said, rebooted = start(rig, axis, chance.uniform(0.0, duration(None)))
    assert rebooted
    if said is None:
        check_limits(rig, axis)
    else:
        assert f"joint q{axis + 1}" in said
