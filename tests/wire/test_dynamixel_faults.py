"""What the Dynamixel driver finds wrong on an emulated chain while it runs."""

import errno

import pytest
from dynamixel_bench import PERIOD, STEP, Bench, joints

from drivers.sim.dynamixel import control_table as table
from rig.hal import DeviceFault

RUNNING_FAULT_CYCLES = 3


@pytest.fixture(params=[True, False], ids=["fast", "one by one"])
def fast(request):
    return request.param


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


def late_cycle(bench, share):
    """Run a cycle whose setpoints and request go out so late that `share` of it remains."""
    start = bench.clock.now()
    bench.bus.receive(start)
    bench.device.check(start)
    bench.clock.sleep_until(start + (1.0 - share) * PERIOD)
    bench.bus.transmit(bench.clock.now())
    bench.clock.sleep_until(start + PERIOD)


def test_a_request_that_was_sent_too_late_for_its_answer_is_not_the_servos_doing():
    bench = Bench(6).start()
    bench.cycle(count=5)
    for _ in range(10):
        late_cycle(bench, 0.02)
    bench.cycle(count=3)
    assert bench.bus.statistics()["missed"] == 0
    assert bench.device.positions().age(bench.clock.now()) < 2.5 * PERIOD


def test_a_servo_that_is_silent_is_found_although_cycles_are_a_little_late():
    bench = Bench(3).start()
    bench.cycle(count=5)
    bench.node.inject("joint_2.silent")
    with pytest.raises(DeviceFault, match="does not answer any more"):
        for _ in range(10):
            late_cycle(bench, 0.75)
