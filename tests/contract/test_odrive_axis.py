"""The ODrive driver on emulated axes: motion, stops, and every way in which an axis can fail."""

import struct

import pytest
from servo_bench import PERIOD, LaggedJoints, odrive_rig

from drivers.odrive.settings import OdriveEndpoints
from drivers.sim.frame_faults import FrameFault
from rig.hal import ConnectionFailed, DeviceFault

ENDPOINTS = OdriveEndpoints(
    enable_watchdog=300, watchdog_timeout=301, heartbeat_period=400, encoder_period=401
)


@pytest.fixture
def rig():
    made = odrive_rig()
    made.start()
    return made


def turn(rig, cycles, speed=0.5):
    rig.run(cycles, lambda k: rig.driver.command_velocities((speed,) * len(rig.plant.angles)))


def states(rig):
    return [node.axis_state for node in rig.side.nodes]


@pytest.mark.parametrize("mode", ["position", "velocity"])
def test_a_start_makes_no_bump(mode):
    plant = LaggedJoints(2, start=0.7)
    rig = odrive_rig(plant=plant, mode=mode)
    rig.start()
    rig.run(20, lambda k: rig.driver.command_positions((0.7, 0.7)))
    assert plant.angles == pytest.approx([0.7, 0.7], abs=1e-4)
    assert states(rig) == [8, 8]


@pytest.mark.parametrize("mode", ["position", "velocity"])
def test_velocities_and_positions_are_followed_with_the_joints_own_signs(mode):
    rig = odrive_rig(3, mode=mode)
    rig.start()
    turn(rig, 100, -0.4)
    assert rig.plant.angles == pytest.approx([-0.2] * 3, abs=0.01)
    assert rig.driver.velocities().value == pytest.approx([-0.4] * 3, abs=0.05)
    target = -0.2
    for _ in range(100):
        target += 0.3 * PERIOD
        rig.cycle(lambda target=target: rig.driver.command_positions((target,) * 3))
    assert rig.plant.angles == pytest.approx([target] * 3, abs=0.01)
    reading = rig.driver.positions()
    assert reading.value == pytest.approx(rig.plant.angles, abs=0.01)
    assert rig.clock.now() - reading.t == pytest.approx(2 * PERIOD)


def test_parameters_that_the_profile_can_write_are_written():
    rig = odrive_rig(endpoints=ENDPOINTS, watchdog=0.04)
    node = rig.side.nodes[0]
    assert not node.enable_watchdog
    assert node.encoder_msg_rate_ms == 10
    rig.start()
    assert node.enable_watchdog
    assert node.watchdog_timeout == pytest.approx(0.04)
    assert (node.heartbeat_msg_rate_ms, node.encoder_msg_rate_ms) == (20, 5)
    turn(rig, 20)


def test_the_watchdog_takes_the_torque_away_when_the_master_falls_silent(rig):
    turn(rig, 40)
    rig.clock.sleep_until(rig.clock.now() + 0.04)
    assert states(rig) == [8, 8], "50 ms have not passed"
    rig.clock.sleep_until(rig.clock.now() + 0.02)
    assert states(rig) == [1, 1]
    assert rig.plant.powered == [False, False]
    with pytest.raises(DeviceFault, match=r"joint q1 .*watchdog expired.*0x01000000.*IDLE"):
        rig.run(5)


def test_after_that_a_new_start_clears_the_watchdog_and_nothing_else(rig):
    rig.clock.sleep_until(rig.clock.now() + 0.2)
    assert rig.side.nodes[0].active_errors == 0x01000000
    rig.driver.close()
    rig.driver.connect()
    rig.driver.arm()
    rig.run(40)
    assert rig.driver.is_enabled
    assert states(rig) == [8, 8]


@pytest.mark.parametrize("mode", ["position", "velocity"])
def test_the_safe_state_is_a_ramp_that_close_finishes(mode):
    rig = odrive_rig(mode=mode, plant=LaggedJoints(2, lag=0.05, fall=1.0))
    rig.start()
    turn(rig, 40, 0.8)
    rig.safe_cycles(5)
    assert rig.plant.speeds == pytest.approx([0.6, 0.6], abs=0.08)  # 25 ms at 8 rad/s²
    begun = rig.clock.now()
    rig.driver.close()
    assert rig.clock.now() - begun == pytest.approx(0.075, abs=0.07)
    assert rig.plant.speeds == pytest.approx([0.0, 0.0], abs=0.05)
    rig.clock.sleep_until(rig.clock.now() + 0.01)
    assert rig.plant.powered == [False, False]
    rig.bus.make_safe()
    rig.driver.close()
    rig.bus.close()
    rig.bus.close()


def test_torque_off_slows_down_first_and_on_again_holds(rig):
    turn(rig, 40, 0.8)
    rig.driver.set_torque_enabled(False)
    rig.run(10)
    assert rig.plant.powered == [True, True]
    rig.run(30)
    assert states(rig) == [1, 1]
    rig.driver.set_torque_enabled(True)
    stood = list(rig.plant.angles)
    rig.run(30)
    assert rig.driver.is_enabled
    assert rig.plant.angles == pytest.approx(stood, abs=1e-3)


FAULTS = [
    ("axis_error", None, r"over-voltage of the DC bus \(errors 0x00000100\), axis state 1 \(IDLE"),
    ("axis_error", 0x4000000, "spinout"),
    ("disarm", None, "left its closed loop by itself: no error"),
    ("stuck", None, "does not follow its reference"),
    ("encoder_jump", 0.5, r"position jumped.*\+0\.4[5-9]"),
    ("silent", None, r"sends no encoder estimates|heartbeat is lost"),
    ("heartbeat_silent", None, "heartbeat is lost"),
    ("estimates_silent", None, "sends no encoder estimates"),
    ("reboot", None, "left its closed loop by itself"),
]


@pytest.mark.parametrize(("fault", "value", "message"), FAULTS)
def test_an_axis_that_fails_in_mid_path_is_named_and_the_others_stop(fault, value, message):
    rig = odrive_rig(3)
    rig.start()
    turn(rig, 40)
    rig.inject("arm.q2", fault, value)
    with pytest.raises(DeviceFault, match=message) as caught:
        turn(rig, 100)
    assert "arm joint q2 (node 0x02)" in str(caught.value)
    assert "axis state" in str(caught.value)
    with pytest.raises(DeviceFault):  # it stays
        rig.driver.check(rig.clock.now())
    before, fastest = rig.plant.speeds[0], 0.0
    for _ in range(40):
        rig.safe_cycles(1)
        fastest = max(fastest, (before - rig.plant.speeds[0]) / PERIOD)
        before = rig.plant.speeds[0]
    assert abs(rig.plant.speeds[0]) < 0.01
    assert fastest < 1.5 * 8.0
    assert states(rig)[0] == 8, "held"


@pytest.mark.parametrize(
    ("fault", "value", "message"),
    [
        ("silent", None, r"joint q1 .*no heartbeat"),
        ("heartbeat_silent", None, r"joint q1 .*no heartbeat"),
        ("estimates_silent", None, r"estimates come too seldom"),
        ("sdo_silent", None, r"cannot be read back.*endpoint 301 \(watchdog_timeout\)"),
        ("axis_error", 0x40000000, r"reports an error before it is used: calibration failed"),
    ],
)
def test_an_axis_that_cannot_be_configured_is_named(fault, value, message):
    rig = odrive_rig(endpoints=ENDPOINTS)
    rig.clock.sleep_until(0.01)
    rig.inject("arm.q1", fault, value)
    with pytest.raises(ConnectionFailed, match=message):
        rig.open()


def test_old_firmware_is_refused():
    rig = odrive_rig()
    rig.side.nodes[1].answers_version = False
    with pytest.raises(ConnectionFailed, match=r"joint q2 .*does not say its version"):
        rig.open()
    rig = odrive_rig()
    rig.side.nodes[1].firmware = (0, 5, 6)
    with pytest.raises(ConnectionFailed, match=r"firmware 0\.5\.6"):
        rig.open()


def test_two_axes_with_one_number_are_found():
    rig = odrive_rig()
    rig.side.nodes[1].node_id = 1  # somebody forgot to give it a number
    rig.side.nodes[1].serial = 0x99
    with pytest.raises(ConnectionFailed, match=r"joint q2 .*no heartbeat|2 ODrives"):
        rig.open()
    rig = odrive_rig(1)
    twin = odrive_rig(1).side.nodes[0]
    twin.serial, twin.name = 0x99, "twin"
    twin.send = rig.side.nodes[0].send
    rig.side.nodes = (*rig.side.nodes, twin)
    with pytest.raises(ConnectionFailed, match="2 ODrives have this node number"):
        rig.open()


def test_addresses_are_given_by_serial_number(rig):
    node = rig.side.nodes[1]
    node.serial = 0xABC
    node.receive(0x3F << 5 | 6, bytes((9,)) + (0xABC).to_bytes(6, "little"), rig.rig.time)
    assert node.node_id == 9
    node.receive(0x3F << 5 | 6, bytes((7,)) + (0xDEF).to_bytes(6, "little"), rig.rig.time)
    assert node.node_id == 9


@pytest.mark.parametrize(("firmware", "kept"), [((0, 6, 10), 0), ((0, 6, 11), 0x5A)])
def test_the_number_of_a_connection_is_kept_by_firmware_that_knows_it(rig, firmware, kept):
    """ODrive's CAN Protocol, Address: ``Connection_ID`` since 0.6.11, zero before.

    The maker's libodrive takes an axis that answers another number for lost
    (``tests/vcan/test_odrive_maker.py``).
    """
    node = rig.side.nodes[0]
    node.firmware = firmware
    answers = []
    node.send = lambda can_id, data: answers.append(data)
    serial = node.serial.to_bytes(6, "little")
    node.receive(0x7E6, bytes((0x20, *serial, 0x5A)), node.now)
    node.receive(0x7E6, b"", node.now, remote=True)
    assert answers == [bytes((0x20, *serial, kept))]


def test_ids_of_29_bits_are_ignored(rig):
    node = rig.side.nodes[0]
    node.receive(1 << 5 | 2, b"", rig.rig.time, extended=True)
    assert node.axis_state == 8
    node.receive(1 << 5 | 2, b"", rig.rig.time)
    assert (node.axis_state, node.active_errors) == (1, 0x02000000)


def test_both_lengths_of_set_axis_state_are_taken(rig):
    node = rig.side.nodes[0]
    node.receive(1 << 5 | 7, struct.pack("<I", 1), rig.rig.time)
    assert node.axis_state == 1
    node.receive(1 << 5 | 7, struct.pack("<II", 8, 0), rig.rig.time)
    assert node.axis_state == 8
    node.receive(1 << 5 | 7, b"\x01\0\0", rig.rig.time)
    assert node.axis_state == 8


@pytest.mark.parametrize("kind", ["drop", "delay", "duplicate", "truncate"])
@pytest.mark.parametrize("can_id", [0x021, 0x029, 0x02C])
def test_one_bad_frame_is_survived(rig, kind, can_id):
    turn(rig, 40)
    value = {"delay": 6e-3, "truncate": 3}.get(kind, 0.0)
    rig.rig.add_frame_fault("can0", FrameFault(kind, can_id, value=value))
    turn(rig, 60)
    assert rig.plant.angles == pytest.approx([0.25, 0.25], abs=0.02)
    assert states(rig) == [8, 8]


def test_a_corrupted_estimate_is_never_taken():
    for byte in range(4):
        rig = odrive_rig()
        rig.start()
        turn(rig, 20)
        rig.rig.add_frame_fault("can0", FrameFault("corrupt", 0x029, value=byte))
        before = rig.driver.positions().value
        try:
            turn(rig, 3)
        except DeviceFault as fault:
            assert "joint q1" in str(fault)
        assert rig.driver.positions().value == pytest.approx(before, abs=0.03)


def test_speed_above_the_limit_disarms(rig):
    rig.side.nodes[0].speed_limit = 0.3  # turn/s; the joint's 0.5 rad/s are 0.64 turn/s
    with pytest.raises(DeviceFault, match=r"speed above its limit|does not follow"):
        rig.plant.references[0][1] = 1.0
        for _ in range(60):
            turn(rig, 1)
            rig.plant.references[0][1] = 1.0


def test_the_same_seed_gives_the_same_frames():
    def frames():
        rig = odrive_rig()
        rig.start()
        rig.side.frame_loss = 0.02
        turn(rig, 60)
        return rig.frames

    assert frames() == frames()
