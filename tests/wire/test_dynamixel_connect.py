"""The Dynamixel driver before it moves: settings, and a chain that is connected and armed."""

import math
import os
import pty

import pytest
from dynamixel_bench import STEP, Bench, joints

from drivers.dynamixel import registers
from drivers.dynamixel.client import RegisterClient
from drivers.dynamixel.settings import (
    DynamixelAxisSettings,
    DynamixelGains,
    DynamixelSettings,
    SerialBusSettings,
)
from drivers.sim.dynamixel import control_table as table
from rig.hal import ConnectionFailed

# Settings -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (
            {"joints": {"a": DynamixelAxisSettings(id=1), "b": DynamixelAxisSettings(id=1)}},
            "a and b have the",
        ),
        (
            {"joints": {"a": DynamixelAxisSettings(id=1, offset=1.0)}},
            "in mode position; change offset",
        ),
        ({"joints": joints(1), "mode": "current_based_position"}, "goal_current belongs"),
        ({"joints": joints(1), "goal_current": 1.0}, "goal_current belongs"),
        ({"joints": joints(1), "voltage": (12.0, 9.0)}, "voltage is not a rising pair"),
        (
            {"joints": joints(1), "model": "xl430-w250", "current_limit": 1.0},
            "do not measure their current",
        ),
        (
            {
                "joints": {
                    "a": DynamixelAxisSettings(id=1),
                    "b": DynamixelAxisSettings(id=2, model="xl330-m288"),
                }
            },
            "indirect data at different addresses",
        ),
    ],
)
def test_settings_that_cannot_be_are_refused(settings, words):
    with pytest.raises(ValueError, match=words):
        DynamixelSettings(**settings)


def test_two_devices_share_a_bus():
    bench = Bench(2)
    with pytest.raises(ValueError, match="have the same id, 1, on the same bus"):
        type(bench.device)("other", DynamixelSettings(joints=joints(1)), bench.bus)


# Life cycle ---------------------------------------------------------------------------


def test_connect_configures_every_servo_and_leaves_it_without_torque():
    bench = Bench(
        2,
        mode="current_based_position",
        goal_current=0.5,
        current_limit=1.0,
        profile_velocity=2.0,
        gains=DynamixelGains(position_p=900, feedforward_1=50),
    )
    for k in range(2):
        bench.servo(k).table[table.RETURN_DELAY] = 250
        bench.servo(k).table[table.TORQUE] = 1
    bench.bus.open()
    bench.device.connect()
    for k in range(2):
        memory = bench.servo(k).table
        assert memory[table.RETURN_DELAY] == 0
        assert memory[table.OPERATING_MODE] == 5
        assert memory[table.TORQUE] == 0
        assert memory[table.GOAL_CURRENT] == round(0.5 / 2.69e-3)
        assert memory[table.CURRENT_LIMIT] == round(1.0 / 2.69e-3)
        assert memory[table.PROFILE_VELOCITY] == round(2.0 / (0.229 * math.tau / 60))
        assert memory.read(84, 2) == (900).to_bytes(2, "little")
        assert memory.read(90, 2) == (50).to_bytes(2, "little")
    assert bench.plant.torque_on[:2] == [False, False]


def test_eeprom_is_not_written_when_it_is_right():
    bench = Bench(1)
    bench.bus.open()
    bench.device.connect()
    written = []
    original = bench.servo(0).write

    def write(address, data):
        written.append(address)
        return original(address, data)

    bench.servo(0).write = write
    bench.device.connect()
    assert written, "RAM is written each time"
    assert min(written) >= 64, "EEPROM wears"


def test_limits_of_the_joint_are_given_to_the_servo():
    bench = Bench(1, joints={"knee": DynamixelAxisSettings(id=7, limits=(-0.5, 1.0), offset=0.1)})
    bench.bus.open()
    bench.device.connect()
    memory = bench.servo(0).table
    assert memory[table.MIN_POSITION] == round(2048 - 0.6 / STEP)
    assert memory[table.MAX_POSITION] == round(2048 + 0.9 / STEP)


def test_arm_holds_where_the_joints_are():
    bench = Bench(3).start()
    assert bench.plant.torque_on[:3] == [True] * 3
    assert bench.plant.angles[:3] == pytest.approx([0.0, 0.1, 0.2], abs=STEP)
    assert bench.device.positions().value == pytest.approx((0.0, 0.1, 0.2), abs=STEP)


def test_watchdog_is_armed_with_the_first_cycle_and_not_before():
    bench = Bench(2, watchdog=0.05).start()
    bench.clock.sleep_until(bench.clock.now() + 1.0)  # another device takes its time to arm
    bench.cycle(count=10)
    assert bench.servo(0).table[table.WATCHDOG] == 3  # 60 ms, not below 50


@pytest.mark.parametrize(
    ("break_it", "words"),
    [
        (
            lambda b: b.node.inject("joint_2.silent"),
            "joint_2 (id 2): it does not answer; on this chain answer: 1, 3",
        ),
        (lambda b: b.node.inject("silent"), "nor does any servo at 4000000 bit/s; look at the"),
        (
            lambda b: b.node.inject("joint_2.overheated"),
            "joint_2 (id 2): it has a hardware error: over",
        ),
        (lambda b: b.node.inject("joint_2.same_id"), "there are two servos with this id"),
        (lambda b: b.node.inject("joint_2.doubled"), "there are two servos with this id"),
        (lambda b: b.node.inject("joint_2.corrupted"), "its answers are garbled"),
        (lambda b: b.node.inject("joint_2.truncated"), "its answers are garbled"),
        (lambda b: b.servo(1).table.__setitem__(table.MODEL, 1060), "value xl430-w250"),
        (lambda b: b.servo(1).table.__setitem__(table.HOMING_OFFSET, 5), "its zero was moved"),
        (lambda b: setattr(b.world, "_latency", 6e-3), "set the adapter's latency timer"),
    ],
)
def test_connect_refuses_and_names_the_servo(break_it, words):
    bench = Bench(3)
    break_it(bench)
    bench.bus.open()
    with pytest.raises(ConnectionFailed) as failed:
        bench.device.connect()
    assert words in str(failed.value)
    assert failed.value.node in (1, 2)


@pytest.mark.parametrize(
    ("register", "value", "words"),
    [
        (registers.TORQUE_ENABLE, 2, ("Torque Enable (64)", "out of the register's range", "0x04")),
        (registers.GOAL_POSITION, 5000, ("Goal Position (116)", "beyond one of its limits", "06")),
        (registers.PRESENT_POSITION, 0, ("Present Position (132)", "cannot be accessed", "0x07")),
        (registers.OPERATING_MODE, 1, ("Operating Mode (11)", "locked by torque", "0x07")),
    ],
    ids=["range", "limit", "read-only", "locked"],
)
def test_status_error_is_told_in_words_with_joint_id_and_register(register, value, words):
    bench = Bench(3)
    bench.start()
    client = RegisterClient("servos", "joint_2", 2, bench.bus)
    with pytest.raises(ConnectionFailed) as failed:
        client.write(register, value)
    for word in ("joint_2 (id 2): it refused", *words):
        assert word in str(failed.value)


def test_connect_asks_again_when_packets_get_lost():
    bench = Bench(2, frame_loss=0.1, seed=3, bus={"attempts": 8})
    bench.bus.open()
    bench.device.connect()


def test_a_port_that_is_not_there_is_named():
    from drivers.dynamixel.port import open_port

    settings = SerialBusSettings("/dev/no-such-adapter")
    with pytest.raises(ConnectionFailed, match=r"cannot be opened: it is not there; plug it in"):
        open_port(settings)


def test_a_port_that_somebody_else_has_open_says_how_to_find_out_who():
    from drivers.dynamixel.port import open_port

    ours, theirs = pty.openpty()
    name = os.ttyname(theirs)
    first = open_port(SerialBusSettings(name))
    with pytest.raises(
        ConnectionFailed, match=f"another program has it open; which one says: fuser -v {name}"
    ):
        open_port(SerialBusSettings(name))
    first.close()
    os.close(ours)
    os.close(theirs)


def test_arming_outside_the_range_is_refused():
    bench = Bench(1, joints={"knee": DynamixelAxisSettings(id=1, limits=(0.5, 1.0))})
    with pytest.raises(ConnectionFailed, match=r"knee \(id 1\): the joint stands outside"):
        bench.start()
    assert not bench.plant.torque_on[0]


def test_firmware_that_does_not_know_the_fast_reading_is_hinted_at():
    bench = Bench(2)
    bench.line.chain._read_together = lambda *_: b""
    with pytest.raises(ConnectionFailed, match="old firmware needs fast_sync: false"):
        bench.start()
    assert not any(bench.plant.torque_on)
