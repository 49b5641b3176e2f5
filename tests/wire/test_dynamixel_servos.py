"""The Dynamixel driver on an emulated chain: life cycle, cycle, and what it finds wrong."""

import errno
import math

import pytest
from dynamixel_bench import PERIOD, Bench, joints

from drivers.dynamixel import registers
from drivers.dynamixel.client import RegisterClient
from drivers.dynamixel.settings import (
    DynamixelGains,
    DynamixelJoint,
    DynamixelSettings,
    SerialBusSettings,
)
from drivers.sim.dynamixel import control_table as table
from rig.hal import ConnectionFailed, DeviceFault, LimitExceeded

STEP = math.tau / 4096
RUNNING_FAULT_CYCLES = 3


@pytest.fixture(params=[True, False], ids=["fast", "one by one"])
def fast(request):
    return request.param


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
    bench = Bench(1, joints={"knee": DynamixelJoint(id=7, limits=(-0.5, 1.0), offset=0.1)})
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
    with pytest.raises(ConnectionFailed, match="/dev/no-such-adapter: the serial port cannot"):
        open_port(settings)


def test_arming_outside_the_range_is_refused():
    bench = Bench(1, joints={"knee": DynamixelJoint(id=1, limits=(0.5, 1.0))})
    with pytest.raises(ConnectionFailed, match=r"knee \(id 1\): the joint stands outside"):
        bench.start()
    assert not bench.plant.torque_on[0]


def test_firmware_that_does_not_know_the_fast_reading_is_hinted_at():
    bench = Bench(2)
    bench.line.chain._read_together = lambda *_: b""
    with pytest.raises(ConnectionFailed, match="old firmware needs fast_sync: false"):
        bench.start()
    assert not any(bench.plant.torque_on)


# The cycle ----------------------------------------------------------------------------


def test_setpoints_arrive_and_are_read_back_one_cycle_later(fast):
    bench = Bench(3, bus={"fast_sync": fast}).start()
    wanted = (0.25, -0.5, 1.0)
    sent = bench.clock.now()
    bench.cycle(lambda device: device.command_positions(wanted))
    bench.cycle()
    reading = bench.device.positions()
    assert reading.value == pytest.approx(wanted, abs=0.5 * STEP + 1e-12)
    assert reading.t == sent
    assert reading.age(bench.clock.now()) == pytest.approx(2 * PERIOD)
    assert bench.bus.statistics()["missed"] == 0
    assert bench.line.collisions == 0


def test_direction_offset_and_gear():
    names = {
        "plain": DynamixelJoint(id=1, max_speed=1e3),
        "reversed": DynamixelJoint(
            id=2, reversed=True, offset=0.3, limits=(-2.0, 2.0), max_speed=1e3
        ),
        "geared": DynamixelJoint(id=3, gear=2.0, limits=(-1.0, 1.0), max_speed=1e3),
    }
    bench = Bench(3, joints=names).start()
    bench.cycle(lambda device: device.command_positions((0.4, 0.4, 0.4)), count=3)
    counts = [bench.servo(k).table[table.GOAL_POSITION] for k in range(3)]
    assert counts == [2048 + round(0.4 / STEP), 2048 - round(0.1 / STEP), 2048 + round(0.8 / STEP)]
    assert bench.plant.angles[:3] == pytest.approx([0.4] * 3, abs=STEP)
    assert bench.device.positions().value == pytest.approx((0.4,) * 3, abs=STEP)


def test_velocity_mode_turns_and_stops():
    bench = Bench(2, mode="velocity").start()
    bench.cycle(lambda device: device.command_velocities((0.5, -0.5)), count=41)
    assert bench.device.velocities().value == pytest.approx((0.5, -0.5), abs=0.013)
    moved = 0.2 * 0.5
    assert bench.plant.angles[:2] == pytest.approx([moved, 0.1 - moved], abs=5e-3)
    bench.device.make_safe()
    bench.bus.transmit(bench.clock.now())
    bench.clock.sleep_until(bench.clock.now() + PERIOD)
    assert bench.plant.velocities[:2] == [0.0, 0.0]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1.01, -1.01])
def test_setpoints_out_of_range_are_refused_and_change_nothing(bad):
    bench = Bench(2, joints=joints(2, limits=(-1.0, 1.0))).start()
    bench.cycle(lambda device: device.command_positions((0.5, 0.5)))
    with pytest.raises(LimitExceeded, match="joint_2: position setpoint"):
        bench.device.command_positions((0.0, bad))
    with pytest.raises(LimitExceeded, match="joint_1: velocity setpoint"):
        bench.device.command_velocities((bad * 1e4, 0.0))
    bench.cycle(count=2)
    assert bench.plant.angles[:2] == pytest.approx([0.5, 0.5], abs=STEP)


def test_the_end_of_the_turn_is_the_last_count():
    bench = Bench(1).start()
    bench.cycle(lambda device: device.command_positions((math.pi,)), count=2)
    assert bench.servo(0).table[table.GOAL_POSITION] == 4095


def test_velocities_are_integrated_in_position_mode():
    bench = Bench(2).start()
    bench.cycle(lambda device: device.command_velocities((0.5, -0.5)), count=100)
    assert bench.plant.angles[:2] == pytest.approx([0.25, 0.1 - 0.25], abs=2 * STEP)


def test_positions_are_followed_in_velocity_mode():
    bench = Bench(2, mode="velocity", position_gain=20.0).start()
    bench.cycle(lambda device: device.command_positions((0.05, 0.15)), count=100)
    # A servo counts velocities in steps of 0.024 rad/s, below which it stands still.
    assert bench.plant.angles[:2] == pytest.approx([0.05, 0.15], abs=0.024 / 20.0 + STEP)


def test_a_jump_of_the_setpoint_is_refused():
    bench = Bench(1, joints=joints(1, max_speed=2.0)).start()
    bench.cycle(lambda device: device.command_positions((1.9 * PERIOD,)))
    with pytest.raises(LimitExceeded, match="position setpoint"):
        bench.device.command_positions((0.5,))


def test_torques_come_from_the_motor_currents():
    bench = Bench(
        2,
        joints={
            "plain": DynamixelJoint(id=1),
            "geared": DynamixelJoint(id=2, gear=3.0, reversed=True),
        },
        mode="extended_position",
    )
    bench.plant.joint_torque = lambda channel: (1.5, -2.0)[channel]
    bench.start()
    step = 2.69e-3 * 4.1 / 2.3
    assert bench.device.torques().value == pytest.approx((1.5, -2.0), abs=2 * step)


def test_torque_is_released_and_taken_again():
    bench = Bench(2).start()
    bench.cycle()
    bench.device.set_torque_enabled(False)
    bench.cycle(count=2)
    assert bench.plant.torque_on[:2] == [False, False]
    bench.plant.angles[0] = 0.7  # somebody moves it by hand
    bench.cycle(count=200)  # and that is no joint that does not follow
    bench.device.set_torque_enabled(True)
    bench.cycle(count=2)
    assert bench.plant.torque_on[:2] == [True, True]
    assert bench.plant.angles[0] == pytest.approx(0.7, abs=STEP)


@pytest.mark.parametrize("stop", ["hold", "release"])
def test_make_safe_holds_or_releases_and_takes_no_more_setpoints(stop):
    bench = Bench(2, after_stop=stop).start()
    bench.cycle(lambda device: device.command_positions((0.3, 0.3)), count=2)
    bench.device.make_safe()
    bench.device.command_positions((0.9, 0.9))
    for _ in range(5):
        bench.bus.transmit(bench.clock.now())
        bench.clock.sleep_until(bench.clock.now() + PERIOD)
    assert bench.plant.torque_on[:2] == [stop == "hold"] * 2
    assert bench.plant.angles[:2] == pytest.approx([0.3, 0.3], abs=STEP)
    bench.device.close()
    bench.bus.close()
    bench.device.close()
    bench.bus.close()
    bench.clock.sleep_until(bench.clock.now() + 0.2)
    assert bench.servo(0).table[table.WATCHDOG] == -1, "nobody watches over it any more"


def test_two_devices_share_a_bus():
    bench = Bench(2)
    with pytest.raises(ValueError, match="have the same id, 1, on the same bus"):
        type(bench.device)("other", DynamixelSettings(joints=joints(1)), bench.bus)


def test_same_seed_same_bytes():
    def run():
        bench = Bench(3, frame_loss=0.002, seed=11, bus={"fault_after": 5, "attempts": 6})
        sent = []
        bench.line.monitor = lambda t, data: sent.append((t, data))
        bench.start()
        for k in range(200):
            target = 0.3 * math.sin(0.05 * k)
            bench.cycle(lambda device, target=target: device.command_positions((target,) * 3))
        return sent

    assert run() == run()


# Faults -------------------------------------------------------------------------------


def cycles_from(bench, inject):
    bench.cycle(count=4)
    inject()
    return bench.cycles_until_fault()


@pytest.mark.parametrize("k", [0, 4, 11])
def test_a_silent_servo_is_named_whatever_its_place(k, fast):
    bench = Bench(12, bus={"fast_sync": fast}).start()
    cycles, fault = cycles_from(bench, lambda: bench.node.inject(f"joint_{k + 1}.silent"))
    assert cycles <= RUNNING_FAULT_CYCLES
    assert isinstance(fault, DeviceFault)
    assert fault.node == k + 1
    assert f"joint_{k + 1} (id {k + 1}) does not answer any more" in str(fault)
    assert "Present Position" not in str(fault)
    assert "Present Current (126) … Present Temperature (146)" in str(fault)


@pytest.mark.parametrize("how", ["corrupted", "truncated", "same_id"])
@pytest.mark.parametrize("k", [0, 2, 3])
def test_damaged_answers_are_named(how, k, fast):
    bench = Bench(4, bus={"fast_sync": fast}).start()
    cycles, fault = cycles_from(bench, lambda: bench.node.inject(f"joint_{k + 1}.{how}"))
    assert cycles <= RUNNING_FAULT_CYCLES
    assert f"the status packets of joint_{k + 1} (id {k + 1}) are corrupted" in str(fault)
    assert fault.node == k + 1
    assert bench.bus.statistics()["damaged"] >= 2


def test_doubled_answers_are_named():
    bench = Bench(4, bus={"fast_sync": False}).start()
    cycles, fault = cycles_from(bench, lambda: bench.node.inject("joint_3.doubled"))
    assert cycles <= RUNNING_FAULT_CYCLES
    assert "joint_3 (id 3) answers twice; there are two servos with this id" in str(fault)


@pytest.mark.parametrize(
    ("fault_name", "words"),
    [
        ("overheated", "reports a hardware error: overheated [object Hardware Error Status (70)"),
        ("overloaded", "reports a hardware error: overloaded for too long"),
        ("shock", "electrical shock, or too little power"),
        ("encoder_broken", "motor encoder broken"),
        ("undervoltage", "input voltage out of range"),
        ("warm", "is too hot [object Present Temperature (146), value 75 °C, bound 70 °C"),
        ("rebooted", "has lost its settings: its bus watchdog is not what was written"),
    ],
)
def test_what_a_servo_says_of_itself_is_a_fault_in_words(fault_name, words):
    bench = Bench(3).start()
    cycles, fault = cycles_from(bench, lambda: bench.node.inject(f"joint_2.{fault_name}"))
    assert cycles <= RUNNING_FAULT_CYCLES
    assert "joint_2 (id 2) " in str(fault)
    assert words in str(fault)
    assert fault.node == 2


def test_without_health_a_hardware_error_still_shows():
    bench = Bench(3, health=False).start()
    cycles, fault = cycles_from(bench, lambda: bench.node.inject("joint_3.overloaded"))
    assert cycles <= RUNNING_FAULT_CYCLES
    assert "joint_3 (id 3) reports a hardware error" in str(fault)


def test_voltage_out_of_bounds():
    bench = Bench(2, voltage=(11.0, 13.0)).start()
    cycles, fault = cycles_from(bench, lambda: bench.servo(1).table.__setitem__(table.VOLTAGE, 105))
    assert cycles <= RUNNING_FAULT_CYCLES
    assert "value 10.5 V, bound 11 … 13 V" in str(fault)


def test_a_tripped_watchdog_is_recognised():
    bench = Bench(3, watchdog=0.04).start()
    bench.cycle(count=5)
    bench.clock.sleep_until(bench.clock.now() + 0.1)  # the loop stalls
    cycles, fault = bench.cycles_until_fault()
    assert cycles <= RUNNING_FAULT_CYCLES
    assert "has stopped by itself: its bus watchdog tripped" in str(fault)
    assert "Bus Watchdog (98), value -1" in str(fault)


def test_a_tripped_watchdog_is_cleared_by_connecting_again():
    bench = Bench(2).start()
    bench.cycle(count=2)
    bench.clock.sleep_until(bench.clock.now() + 0.1)
    bench.cycles_until_fault()
    bench.device.make_safe()
    bench.device.close()
    bench.device.connect()
    bench.device.arm()
    bench.cycle(lambda device: device.command_positions((0.5, 0.5)), count=3)
    assert bench.plant.angles[:2] == pytest.approx([0.5, 0.5], abs=STEP)


def test_an_adapter_that_is_pulled_out_is_found_at_once():
    bench = Bench(3).start()
    cycles, fault = cycles_from(bench, lambda: bench.line.inject("unplugged"))
    assert cycles <= RUNNING_FAULT_CYCLES
    assert fault.device == "chain"
    assert "the serial adapter is gone while in use" in str(fault)
    bench.device.make_safe()
    bench.bus.make_safe()
    bench.device.close()
    bench.bus.close()


def test_a_chain_without_power_is_not_blamed_on_one_servo():
    bench = Bench(3).start()

    cycles, fault = cycles_from(bench, lambda: bench.node.inject("silent"))
    assert cycles <= RUNNING_FAULT_CYCLES
    assert "no servo answers any more; look at their power and at the cable" in str(fault)


def test_a_blocked_joint_does_not_follow():
    bench = Bench(2, following_window=0.2, following_time=0.1).start()
    bench.plant.blocked.add(1)
    bench.cycle(lambda device: device.command_positions((0.5, 0.5)))
    cycles, fault = bench.cycles_until_fault(limit=40)
    assert "joint_2 (id 2) does not follow its setpoint" in str(fault)
    assert cycles * PERIOD == pytest.approx(0.1, abs=4 * PERIOD)


def test_a_position_that_jumps_is_a_fault():
    bench = Bench(2, joints=joints(2, max_speed=2.0)).start()

    def strike():
        bench.plant.blocked.add(1)
        bench.plant.angles[1] += 0.1

    cycles, fault = cycles_from(bench, strike)
    assert cycles <= RUNNING_FAULT_CYCLES
    assert "joint_2 (id 2) jumped" in str(fault)


def test_a_joint_at_rest_is_held_in_velocity_mode():
    bench = Bench(1, mode="velocity").start()
    bench.cycle(lambda device: device.command_velocities((0.0,)), count=5)
    bench.plant.angles[0] += 0.02  # it is pushed
    bench.cycle(lambda device: device.command_velocities((0.0,)), count=100)
    assert bench.plant.angles[0] == pytest.approx(0.0, abs=0.024 / 10.0 + STEP)


def test_a_lost_packet_is_counted_and_the_reading_held(fast):
    bench = Bench(3, bus={"fast_sync": fast}).start()
    bench.cycle(count=3)
    before = bench.device.positions()
    bench.node.inject("joint_2.silent")
    bench.cycle()  # its request is not answered
    bench.node.inject("repair")
    bench.cycle()
    assert bench.device.positions().t == before.t + PERIOD
    assert bench.bus.statistics()["missed"] > 0
    bench.cycle(count=5)
    assert bench.device.positions().age(bench.clock.now()) == pytest.approx(2 * PERIOD)


def test_noise_on_the_line_costs_nothing(fast):
    bench = Bench(3, bus={"fast_sync": fast}).start()
    bench.cycle(count=2)
    for _ in range(20):
        bench.line.inject("noise", 13)
        bench.cycle()
    assert bench.bus.statistics()["noise"] >= 20 * 10


def test_a_port_that_takes_no_bytes_is_a_fault():
    bench = Bench(2).start()
    bench.cycle(count=2)
    bench.line.port.write = lambda data: 0
    _, fault = bench.cycles_until_fault()
    assert "takes no bytes any more" in str(fault) or "no servo answers" in str(fault)
    assert bench.bus.statistics()["refused"] >= 2


def test_an_operating_system_error_keeps_its_words():
    bench = Bench(1).start()

    def fail(size):
        raise OSError(errno.EIO, "Input/output error")

    bench.line.port.read = fail
    _, fault = bench.cycles_until_fault()
    assert "[Errno 5] Input/output error" in str(fault)


def test_the_host_that_speaks_too_early_is_heard_by_nobody():
    """The emulated line is half duplex: so is the driver, or this would happen to it."""
    bench = Bench(3, bus={"baudrate": 115_200, "reply_timeout": 0.1}).start()
    bench.cycles_until_fault()
    assert bench.line.collisions > 0


# Settings -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"joints": {"a": DynamixelJoint(id=1), "b": DynamixelJoint(id=1)}}, "a and b have the"),
        ({"joints": {"a": DynamixelJoint(id=1, offset=1.0)}}, "in mode position; change offset"),
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
                    "a": DynamixelJoint(id=1),
                    "b": DynamixelJoint(id=2, model="xl330-m288"),
                }
            },
            "indirect data at different addresses",
        ),
    ],
)
def test_settings_that_cannot_be_are_refused(settings, words):
    with pytest.raises(ValueError, match=words):
        DynamixelSettings(**settings)
