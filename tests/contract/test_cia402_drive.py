"""The CiA 402 driver on emulated drives: motion, stops, and every way in which a drive can fail."""

import math
import shutil
import struct
import subprocess

import pytest
from servo_bench import PERIOD, LaggedJoints, cia402_rig

from drivers.sim.frame_faults import FrameFault
from drivers.sim.nodes.drive_states import State
from rig.hal import ConnectionFailed, DeviceFault


@pytest.fixture
def rig():
    made = cia402_rig()
    made.start()
    return made


def ramp(rig, speed=0.5):
    """Return a command that moves every joint from where it is, one period per call."""
    targets = list(rig.driver.positions().value)

    def command(_):
        targets[:] = [target + speed * PERIOD for target in targets]
        rig.driver.command_positions(tuple(targets))

    return command


def turn(rig, cycles, speed=0.5):
    rig.run(cycles, lambda k: rig.driver.command_velocities((speed,) * len(rig.plant.angles)))


def states(rig):
    return [node.machine.state for node in rig.side.nodes]


def stopping_times(rig, threshold=1e-3, cycles=200):
    """Return when each joint stood still, s, and the greatest decelerations on the way."""
    begun = rig.clock.now()
    times = [None] * len(rig.plant.angles)
    fastest = [0.0] * len(times)
    before = list(rig.plant.speeds)
    for _ in range(cycles):
        rig.safe_cycles(1)
        for k, speed in enumerate(rig.plant.speeds):
            fastest[k] = max(fastest[k], (before[k] - speed) / PERIOD)
            if times[k] is None and abs(speed) < threshold:
                times[k] = rig.clock.now() - begun
        before = list(rig.plant.speeds)
    return times, fastest


# Motion ----------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["csp", "csv"])
def test_a_start_makes_no_bump(mode):
    plant = LaggedJoints(2, start=0.7)
    rig = cia402_rig(plant=plant, mode=mode)
    rig.start()
    rig.run(20, lambda k: rig.driver.command_positions((0.7, 0.7)))
    assert plant.angles == pytest.approx([0.7, 0.7], abs=2e-6)
    assert states(rig) == [State.ENABLED] * 2


def test_the_drives_go_through_every_state_and_skip_none():
    rig = cia402_rig(1)
    rig.start()
    words = [struct.unpack("<Hib", data)[0] for data in rig.sent(0x201)]
    assert list(dict.fromkeys(words)) == [0x00, 0x06, 0x07, 0x0F]
    shown = [struct.unpack("<Hib", data)[0] & 0x6F for data in rig.sent(0x181)]
    assert list(dict.fromkeys(shown)) == [0x60, 0x21, 0x23, 0x27]


@pytest.mark.parametrize("mode", ["csp", "csv"])
def test_positions_are_followed_with_the_joints_own_signs(mode):
    rig = cia402_rig(3, mode=mode)
    rig.start()
    rig.run(100, ramp(rig))
    # at the end of the last period, but for the bus's 0.3 ms
    assert rig.plant.angles == pytest.approx([0.25] * 3, abs=5e-4)
    reading = rig.driver.positions()
    assert reading.value == pytest.approx(rig.plant.angles, abs=0.005)
    assert rig.driver.velocities().value == pytest.approx([0.5] * 3, abs=0.01)
    assert rig.driver.torques().value == pytest.approx([0.5] * 3, abs=0.06)


@pytest.mark.parametrize("mode", ["csp", "csv"])
def test_velocities_are_followed(mode):
    rig = cia402_rig(mode=mode)
    rig.start()
    turn(rig, 100, -0.4)
    assert rig.plant.speeds == pytest.approx([-0.4, -0.4], rel=1e-3)
    assert rig.plant.angles == pytest.approx([-0.2, -0.2], abs=0.01)


def test_readings_are_quantised_and_bear_the_time_of_their_sync(rig):
    turn(rig, 10)
    reading = rig.driver.positions()
    assert reading.t == rig.bus.syncs.time - PERIOD
    for k, q in enumerate(reading.value):
        drive = rig.driver.settings.joints[f"q{k + 1}"]
        counts = (q - drive.offset) * drive.counts_per_radian
        assert counts == pytest.approx(round(counts), abs=1e-5)


def test_in_csv_a_joint_that_creeps_is_held():
    """A velocity loop lets a joint creep; the driver holds it while it commands no velocity."""
    rig = cia402_rig(1, mode="csv")
    rig.start()
    turn(rig, 20)
    stood = None
    for k in range(200):
        rig.plant.angles[0] += 1e-4  # it sags by 0.02 rad/s ...
        rig.plant.references[0][0] += 1e-4  # ... and the drive's velocity loop does not mind
        rig.side.nodes[0]._motion.position += 1e-4 * rig.side.nodes[0]._counts
        turn(rig, 1, 0.0)
        stood = stood or (rig.plant.angles[0] if k == 0 else None)
    assert rig.plant.angles[0] == pytest.approx(stood, abs=0.004)  # without: 0.02 rad


def test_the_software_limit_stops_a_velocity_before_it():
    rig = cia402_rig(1, mode="csv", limits=(-0.5, 0.5))
    rig.start()
    turn(rig, 300, 1.0)
    assert rig.plant.angles[0] == pytest.approx(0.5, abs=5e-3)
    assert rig.driver.drives[0].status & 0x0800


# Stops -----------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["csp", "csv"])
def test_the_safe_state_is_a_ramp_and_then_a_hold_under_torque(mode):
    plant = LaggedJoints(2, lag=0.002, fall=1.0)
    rig = cia402_rig(plant=plant, mode=mode)
    rig.start()
    turn(rig, 40, 0.8)
    times, fastest = stopping_times(rig)
    assert times == pytest.approx([0.1, 0.1], abs=0.02)  # 0.8 rad/s at 8 rad/s²
    assert max(fastest) < 1.3 * 8.0
    assert states(rig) == [State.QUICK_STOP] * 2
    assert plant.powered == [True, True]
    stood = list(plant.angles)
    rig.safe_cycles(100)
    assert plant.angles == pytest.approx(stood, abs=1e-6)


def test_after_a_stop_the_torque_may_be_released_to_brakes():
    rig = cia402_rig(after_stop="release")
    rig.start()
    turn(rig, 40, 0.8)
    rig.safe_cycles(1)
    assert rig.plant.powered == [True, True]
    rig.safe_cycles(60)
    assert states(rig) == [State.DISABLED] * 2
    assert rig.plant.powered == [False, False]


def test_the_drives_stop_by_themselves_when_the_master_falls_silent(rig):
    turn(rig, 40, 0.8)
    rig.clock.sleep_until(rig.clock.now() + 0.1)
    assert states(rig) == [State.ENABLED] * 2, "the time-out has not passed"
    rig.clock.sleep_until(rig.clock.now() + 0.5)
    assert states(rig) == [State.QUICK_STOP] * 2
    assert rig.plant.speeds == pytest.approx([0.0, 0.0], abs=1e-6)
    assert rig.plant.powered == [True, True]
    assert all(data[:2] == bytes.fromhex("3081") for data in rig.sent(0x081))


def test_closing_stops_the_nodes_in_any_state_and_twice(rig):
    turn(rig, 10)
    rig.driver.close()
    rig.bus.make_safe()
    rig.driver.close()
    rig.bus.close()
    rig.bus.close()
    rig.clock.sleep_until(rig.clock.now() + 0.5)
    assert {node.state for node in rig.side.nodes} == {4}
    assert rig.plant.speeds == pytest.approx([0.0, 0.0], abs=1e-6)
    cia402_rig().driver.close()


def test_torque_off_and_on_again(rig):
    rig.driver.set_torque_enabled(False)
    rig.run(30)
    assert states(rig) == [State.DISABLED] * 2
    assert rig.plant.powered == [False, False]
    assert not rig.driver.is_enabled
    for _ in range(30):
        rig.plant.angles[0] += 0.01  # somebody moves the arm by hand
        rig.run(1)
    rig.driver.set_torque_enabled(True)
    rig.run(30)
    assert rig.driver.is_enabled
    assert rig.plant.angles[0] == pytest.approx(0.3, abs=1e-4)


# Faults ----------------------------------------------------------------------------------

FAULTS = [
    ("drive_fault", None, r"continuous over-current at the motor \(error code 0x2310\)"),
    ("drive_fault", 0x4210, r"drive too hot \(error code 0x4210\), status word 0x02.F \(FAULT REA"),
    ("stuck", None, r"following error too large \(error code 0x8611\)"),
    ("encoder_jump", 0.5, r"position jumped.*\+0.5"),
    ("safe_torque_off", None, r"left OPERATION ENABLED by itself.*SWITCH ON DISABLED"),
    ("wrong_mode", 1, r"mode of operation.*mode 1"),
    ("emergency", 0x7305, r"incremental encoder 1 failed \(error code 0x7305\)"),
    ("silent", None, "does not answer SYNC|heartbeat is lost"),
    ("heartbeat_silent", None, "heartbeat is lost"),
    ("reboot", None, "rebooted while running"),
    ("wrong_state", 127, r"does not answer SYNC|left OPERATIONAL"),
]


@pytest.mark.parametrize(("fault", "value", "message"), FAULTS)
def test_a_drive_that_fails_in_mid_path_is_named_and_the_others_stop(fault, value, message):
    rig = cia402_rig(3, plant=LaggedJoints(3, lag=0.002))
    rig.start()
    command = ramp(rig)
    rig.run(40, command)
    rig.inject("arm.q2", fault, value)
    with pytest.raises(DeviceFault, match=message) as caught:
        rig.run(100, command)
    assert "arm joint q2 (node 0x02)" in str(caught.value)
    assert "status word 0x" in str(caught.value) or "rebooted" in str(caught.value)
    with pytest.raises(DeviceFault):  # it stays
        rig.driver.check(rig.clock.now())
    times, fastest = stopping_times(rig, cycles=60)
    for k in (0, 2):
        assert states(rig)[k] is State.QUICK_STOP
        assert times[k] is not None
        assert times[k] < 0.2
        assert fastest[k] < 1.3 * 8.0


def test_a_blocked_joint_is_a_following_error_of_the_drive(rig):
    rig.plant.blocked.add(0)
    with pytest.raises(DeviceFault, match=r"joint q1 .*following error too large.*0x8611"):
        rig.run(200, ramp(rig))


def test_in_csv_a_blocked_joint_is_found_by_the_rig():
    rig = cia402_rig(mode="csv")
    rig.start()
    rig.plant.blocked.add(1)
    with pytest.raises(DeviceFault, match=r"joint q2 .*does not follow its reference"):
        turn(rig, 200, 1.5)


def test_a_fault_is_reset_by_the_operator_only():
    rig = cia402_rig()
    rig.start()
    rig.inject("arm.q1", "drive_fault", 0x4310)
    with pytest.raises(DeviceFault):
        rig.run(5)
    rig.safe_cycles(200)
    assert states(rig)[0] is State.FAULT, "no cycle resets it"
    rig.driver.reset_fault()
    assert states(rig)[0] is State.DISABLED
    rig.driver.connect()
    rig.driver.arm()
    rig.run(30)
    assert rig.driver.is_enabled


def test_a_drive_that_keeps_its_fault_says_so(rig, monkeypatch):
    node = rig.side.nodes[0]
    rig.inject("arm.q1", "drive_fault", 0x3220)
    monkeypatch.setattr(node.machine, "command", lambda word: None)
    rig.safe_cycles(20)
    with pytest.raises(ConnectionFailed, match=r"stays in its fault: under-voltage of the DC link"):
        rig.driver.reset_fault()


def test_a_fault_before_arming_is_named_while_connecting():
    rig = cia402_rig()
    rig.bus.open()
    restore = rig.side.nodes[1].restore_process

    def fail_at_power_on():
        restore()
        rig.side.nodes[1].inject("drive_fault", 0x7305)

    rig.side.nodes[1].restore_process = fail_at_power_on
    with pytest.raises(ConnectionFailed) as caught:
        rig.driver.connect()
    text = str(caught.value)
    for part in ("arm joint q2", "node 0x02", "incremental encoder 1", "0x7305", "(FAULT)"):
        assert part in text


@pytest.mark.parametrize(
    ("fault", "value", "message"),
    [
        ("wrong_device_type", 0x0191, r"joint q1 \(node 0x01\).*CiA 401"),
        ("sdo_abort", 0x6085_00, r"refused.*0x6085:00"),
        ("sdo_silent", None, r"joint q1 .*did not answer"),
        ("silent", None, r"joint q1 .*did not answer"),
    ],
)
def test_a_drive_that_cannot_be_configured_is_named(fault, value, message):
    rig = cia402_rig()
    rig.inject("arm.q1", fault, value)
    with pytest.raises(ConnectionFailed, match=message):
        rig.open()


def test_a_wrong_serial_number_is_refused():
    rig = cia402_rig(1, serial=77)
    serial = rig.side.nodes[0].dictionary.find(0x1018, 4)
    serial.value = serial.default = 78
    with pytest.raises(ConnectionFailed, match=r"serial number.*0x1018:04.*78.*77"):
        rig.open()


def test_an_operators_scale_that_is_not_the_drives_is_refused():
    rig = cia402_rig(1)
    feed = rig.side.nodes[0].dictionary.find(0x6092, 1)
    feed.value = feed.default = 4096
    with pytest.raises(ConnectionFailed, match=r"position unit.*4096 counts.*131072 counts"):
        rig.open()


# The wire --------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["drop", "delay", "duplicate", "truncate"])
@pytest.mark.parametrize("can_id", [0x181, 0x281, 0x201, 0x080])
def test_one_bad_frame_is_survived(kind, can_id):
    rig = cia402_rig()
    rig.start()
    command = ramp(rig)
    rig.run(40, command)
    value = {"delay": 6e-3, "truncate": 3}.get(kind, 0.0)
    rig.rig.add_frame_fault("can0", FrameFault(kind, can_id, value=value))
    if kind == "truncate" and can_id == 0x201:
        with pytest.raises(DeviceFault, match="0x8210"):  # the drive complains, as it should
            rig.run(10, command)
        return
    rig.run(60, command)
    assert rig.plant.speeds == pytest.approx([0.5, 0.5], rel=1e-3)


@pytest.mark.parametrize("can_id", [0x181, 0x281])
def test_a_corrupted_position_or_status_is_never_taken(can_id):
    for byte in range(6):
        rig = cia402_rig()
        rig.start()
        command = ramp(rig)
        rig.run(20, command)
        rig.rig.add_frame_fault("can0", FrameFault("corrupt", can_id, value=byte))
        before = rig.driver.positions().value
        try:
            rig.run(3, command)
        except DeviceFault as fault:
            assert "joint q1" in str(fault)
        assert rig.driver.positions().value == pytest.approx(before, abs=0.02)


def test_frames_that_stay_away_are_held_and_then_a_fault(rig):
    rig.rig.add_frame_fault("can0", FrameFault("drop", 0x181, count=4))
    rig.run(20)
    assert rig.bus.statistics()["held_samples"] >= 2
    rig.rig.add_frame_fault("can0", FrameFault("drop", 0x181, count=10))
    with pytest.raises(DeviceFault, match=r"joint q1 .*does not answer SYNC.*5 missed in a row"):
        rig.run(20)


def test_a_lossy_bus_does_not_stop_the_rig_nor_move_it_elsewhere():
    rig = cia402_rig(6, loss=0.0)
    rig.start()
    rig.side.frame_loss = 0.01
    rig.run(400, ramp(rig, 0.2))
    rig.side.frame_loss = 0.0
    rig.run(10)
    assert rig.plant.angles == pytest.approx([0.4] * 6, abs=5e-3)


def test_a_foreign_frame_is_counted_and_ignored(rig):
    rig.side.send_foreign(0x18F, bytes(7))
    rig.side.send_foreign(0x181, bytes(7), extended=True)
    rig.run(3)
    assert rig.bus.statistics()["unknown"] == 2
    assert rig.driver.is_enabled


def test_the_same_seed_gives_the_same_frames():
    def frames():
        rig = cia402_rig(2)
        rig.start()
        rig.side.frame_loss = 0.02
        rig.run(100, ramp(rig))
        return rig.frames

    assert frames() == frames()


@pytest.mark.skipif(shutil.which("tshark") is None, reason="tshark is not installed")
def test_wireshark_knows_every_frame_of_a_run(tmp_path):
    """From the reset to a fault and the stop: named, and none malformed."""
    rig = cia402_rig(2)
    rig.start()
    rig.run(20, ramp(rig))
    rig.inject("arm", "q2.drive_fault")
    with pytest.raises(DeviceFault):
        rig.run(10)
    rig.safe_cycles(5)
    log = tmp_path / "run.log"
    log.write_text(
        "".join(f"({t:.6f}) vcan0 {i:03X}#{data.hex().upper()}\n" for t, i, data in rig.frames)
    )
    command = ["tshark", "-r", str(log), "-d", "can.subdissector,canopen", "-T", "fields"]
    lines = subprocess.run(
        [*command, "-e", "_ws.col.Protocol", "-e", "_ws.col.Info"],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    ).stdout.splitlines()
    assert len(lines) == len(rig.frames)
    assert all(line.startswith("CANopen") for line in lines)
    assert not [line for line in lines if "malformed" in line.lower()]
    text = "\n".join(lines)
    for service in ("NMT", "SYNC", "PDO", "SDO", "EMCY", "Boot-up"):
        assert service.lower() in text.lower()


def test_caps_of_speed_and_torque_are_those_of_the_profile():
    rig = cia402_rig(max_speed=2.0, max_torque=30.0)
    rig.start()
    for node, gear in zip(rig.side.nodes, (100.0, 101.0), strict=True):
        rpm = node.objects.greatest_speed.integer
        assert rpm / 60.0 * 2.0 * math.pi / gear == pytest.approx(1.15 * 2.0, rel=2e-3)
    assert [cap for _, cap in rig.plant.caps] == pytest.approx([30.0, 30.0], rel=2e-2)
