"""What may be wrong while a CiA 402 drive runs, and how it is told."""

import pytest
from cia402_bench import Drive, feedback, status

from drivers.can.frame import REMOTE_FLAG
from rig.hal import DeviceFault, LimitExceeded


@pytest.fixture
def arm():
    bench = Drive()
    bench.start()
    return bench


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (0x2310, "continuous over-current at the motor"),
        (0x8611, "following error too large"),
        (0x7305, "incremental encoder 1 failed"),
        (0x4310, "motor too hot"),
        (0xFF01, "device specific"),
        (0x84AA, "speed control"),
    ],
)
def test_a_fault_names_joint_node_status_word_and_error_code(arm, error, words):
    with pytest.raises(DeviceFault) as caught:
        arm.run(0x021F, error=error)
    text = str(caught.value)
    for part in ("arm joint elbow", "node 0x03", words, f"0x{error:04X}", "FAULT REACTION"):
        assert part in text


def test_without_the_code_in_a_pdo_the_emergency_names_it():
    bench = Drive(feedback=("velocity",))
    bench.connect()
    answers = lambda word: [status(word), f"283#{bytes(4).hex()}"]  # noqa: E731
    bench.node.at_sync = answers(0x0240)
    bench.driver.arm()
    bench.interface.put(*answers(0x0218), "083#1086210000000000")
    bench.bus.receive(bench.clock.now())
    with pytest.raises(DeviceFault, match=r"positioning \(error code 0x8610\).*0x0218 \(FAULT\)"):
        bench.driver.check(bench.clock.now())


def test_an_emergency_alone_is_a_fault_with_the_status_word(arm):
    with pytest.raises(DeviceFault, match=r"motor too hot.*0x4310.*0x1227 \(OPERATION ENABLED\)"):
        arm.run(extra=["083#1043080000000000"])


@pytest.mark.parametrize("word", [0x0240, 0x0221, 0x0223, 0x0207])
def test_leaving_operation_enabled_is_a_fault(arm, word):
    with pytest.raises(DeviceFault, match=r"left OPERATION ENABLED by itself: status word"):
        arm.run(word)


def test_another_mode_or_a_following_error_bit_is_a_fault(arm):
    with pytest.raises(DeviceFault, match=r"mode of operation.*mode 1.*mode 8 \(csp\)"):
        arm.run(mode=1)
    arm.driver.drives[0]._shown_mode = 8
    with pytest.raises(DeviceFault, match="reports a following error"):
        arm.run(0x3227)


def test_a_joint_that_stands_still_under_its_commands_is_found(arm):
    with pytest.raises(DeviceFault, match=r"does not follow its reference.*\+0\.\d+ rad for") as c:
        for k in range(60):
            arm.run(0x1A27, command=lambda k=k: arm.driver.command_positions((0.004 * (k + 1),)))
    assert "a limit inside the drive is active" in str(c.value)


def test_a_joint_that_leaves_its_limits_is_found(arm):
    for k in range(1, 401):
        arm.run(position=5 * k, command=lambda k=k: arm.driver.command_positions((0.005 * k,)))
    with pytest.raises(DeviceFault, match=r"left its limits.*2.054 rad.*-1 … 2 rad"):
        for k in range(1, 7):
            arm.run(position=2000 + 9 * k)


def test_a_position_that_jumps_is_not_taken_and_a_fault(arm):
    arm.run(position=3)
    with pytest.raises(DeviceFault, match=r"position jumped.*\+0.097 rad"):
        arm.run(position=100)
    assert arm.driver.positions().value == pytest.approx((0.003,))


def test_drives_that_do_not_enable_are_named():
    bench = Drive(enable_time=0.1)
    bench.connect()
    bench.arm()
    with pytest.raises(DeviceFault, match=r"does not enable operation.*READY TO SWITCH ON.*0.1 s"):
        for _ in range(40):
            bench.run(0x0221)


@pytest.mark.parametrize(
    ("command", "argument", "message"),
    [
        ("command_positions", (2.5,), r"joint elbow: position setpoint is 143.2 deg"),
        ("command_positions", (float("nan"),), "position setpoint is nan"),
        ("command_positions", (0.0051,), r"0.2922 deg, outside -0.2865 … 0.2865 deg"),
        ("command_velocities", (-1.2,), "velocity setpoint is -1.2 rad/s"),
        ("command_velocities", (float("inf"),), "velocity setpoint is inf"),
    ],
)
def test_setpoints_that_no_program_should_send_are_refused(arm, command, argument, message):
    before = arm.driver.drives[0].pdo.data
    with pytest.raises(LimitExceeded, match=message):
        getattr(arm.driver, command)(argument)
    assert arm.driver.drives[0].pdo.data == before


def test_short_foreign_and_remote_frames_change_nothing(arm):
    arm.interface.put("183#27120500", "183#", "18F#2712050000000008", "7A3#05")
    arm.interface.put("183#", flags=REMOTE_FLAG)
    arm.run(position=0)
    assert arm.driver.positions().value == (0.0,)


def test_short_frames_for_long_are_a_fault(arm):
    with pytest.raises(DeviceFault, match=r"wrong length|does not answer SYNC"):
        for _ in range(10):
            arm.interface.put("183#2712", feedback())
            now = arm.clock.now()
            arm.bus.receive(now)
            arm.driver.check(now)
            arm.bus.transmit(now)


def test_a_reboot_while_running_is_a_fault(arm):
    with pytest.raises(DeviceFault, match=r"joint elbow.*rebooted while running"):
        arm.run(extra=["703#00"])


def stopped(bench, word, **fed):
    """Tell the drive to stop, let it answer, and return what is not known to be safe of it."""
    bench.driver.make_safe()
    bench.interface.put(status(word), feedback(**fed))
    bench.bus.receive(bench.clock.now())
    return bench.driver.unsafe(bench.clock.now())


def test_stopped_drive_is_safe_when_its_status_word_and_speed_say_so(arm):
    assert stopped(arm, 0x0207) == ""
    assert stopped(arm, 0x0207, velocity=400) == "arm joint elbow: it still moves, at +0.4 rad/s"
    assert stopped(arm, 0x0240, velocity=400) == ""  # without power: it falls, or is braked
    assert "elbow: it was told to stop, and is still OPERATION ENABLED" in stopped(arm, 0x1227)


def test_stopped_drive_that_fell_silent_is_not_known_to_be_safe(arm):
    arm.driver.make_safe()
    later = arm.clock.now() + 0.4
    assert arm.driver.unsafe(later).startswith("arm joint elbow: not known to be safe")
