"""What may be wrong while an ODrive runs, and how it is told."""

import pytest
from odrive_bench import PERIOD, Bench

from drivers.can.frame import EXTENDED_FLAG
from rig.hal import DeviceFault, LimitExceeded


@pytest.fixture
def arm():
    bench = Bench()
    bench.start()
    return bench


def test_an_error_is_named_in_words_with_joint_and_node(arm):
    arm.axis.errors, arm.axis.state = 0x01000000, 1
    with pytest.raises(DeviceFault) as caught:
        for _ in range(3):
            arm.cycle()
    for part in ("arm joint elbow (node 0x03)", "watchdog expired", "0x01000000", "IDLE"):
        assert part in str(caught.value)


def test_an_axis_that_opens_its_loop_by_itself(arm):
    arm.axis.state = 1
    with pytest.raises(DeviceFault, match=r"left its closed loop.*no error"):
        for _ in range(3):
            arm.cycle()


def test_a_jump_and_no_number_are_not_taken(arm):
    arm.axis.turns = 0.5
    with pytest.raises(DeviceFault, match=r"position jumped.*\+0.5 rad"):
        for _ in range(3):
            arm.cycle()
    assert arm.driver.positions().value == (0.0,)
    bench = Bench()
    bench.start()
    bench.axis.turns = float("nan")
    with pytest.raises(DeviceFault, match="position jumped"):
        for _ in range(3):
            bench.cycle()


@pytest.mark.parametrize(
    ("silent", "message"),
    [("beats", "heartbeat is lost"), ("estimates", "sends no encoder estimates any more")],
)
def test_silence_is_a_fault(arm, silent, message):
    setattr(arm.axis, silent, False)
    with pytest.raises(DeviceFault, match=message):
        for _ in range(60):
            arm.cycle()


def test_a_pause_of_the_loop_makes_no_old_reading_of_a_new_estimate(arm):
    """As when another device takes its time to be armed: the frames wait meanwhile."""
    arm.clock.sleep_until(arm.clock.now() + 0.5)
    arm.cycle()
    assert arm.clock.now() - arm.driver.positions().t <= 2.0 * PERIOD + 1e-9


def test_short_foreign_and_extended_frames_change_nothing(arm):
    arm.interface.put("069#0000003F", "061#00", "08D#0000803F00000000", "063#00")
    arm.interface.put("0FFFFFFE#0011", flags=EXTENDED_FLAG)
    arm.cycle()
    assert arm.driver.positions().value == (0.0,)
    assert arm.bus.statistics()["unknown"] == 2


@pytest.mark.parametrize(
    ("command", "argument", "message"),
    [
        ("command_positions", (2.5,), "joint elbow: position setpoint is 143.2 deg"),
        ("command_positions", (0.006,), "position setpoint is 0.3438 deg"),
        ("command_velocities", (float("nan"),), "velocity setpoint is nan"),
    ],
)
def test_setpoints_that_no_program_should_send_are_refused(arm, command, argument, message):
    with pytest.raises(LimitExceeded, match=message):
        getattr(arm.driver, command)(argument)


def test_a_refused_frame_and_a_lost_link_are_the_buss_faults(arm):
    arm.interface.refusing = OSError(100, "Network is down")
    arm.bus.transmit(arm.clock.now())
    with pytest.raises(DeviceFault, match=r"can0: the interface went down"):
        arm.bus.check(arm.clock.now())
