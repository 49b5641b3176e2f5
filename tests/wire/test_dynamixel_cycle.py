"""The Dynamixel driver in its cycles, on an emulated chain: setpoints, readings, the safe state."""

import math

import pytest
from dynamixel_bench import PERIOD, STEP, Bench, joints

from drivers.dynamixel.settings import DynamixelAxisSettings
from drivers.sim.dynamixel import control_table as table
from rig.hal import LimitExceeded


@pytest.fixture(params=[True, False], ids=["fast", "one by one"])
def fast(request):
    return request.param


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
        "plain": DynamixelAxisSettings(id=1, max_speed=1e3),
        "reversed": DynamixelAxisSettings(
            id=2, reversed=True, offset=0.3, limits=(-2.0, 2.0), max_speed=1e3
        ),
        "geared": DynamixelAxisSettings(id=3, gear=2.0, limits=(-1.0, 1.0), max_speed=1e3),
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
            "plain": DynamixelAxisSettings(id=1),
            "geared": DynamixelAxisSettings(id=2, gear=3.0, reversed=True),
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
