"""What every `rig.hal.ServoBus` does, whatever is behind it: one suite over all of them."""

import pytest
from dynamixel_rig import dynamixel_rig
from servo_bench import PERIOD, LaggedJoints, cia402_rig, odrive_rig, sim_rig

from drivers.cia402.contact_settings import ContactSettings
from rig.hal import DeviceError, DeviceFault, LimitExceeded, Reading
from rig.testing.devices import EmergencyStopSuite

IMPLEMENTATIONS = {
    "cia402-csp": lambda **options: cia402_rig(mode="csp", **options),
    "cia402-csv": lambda **options: cia402_rig(mode="csv", **options),
    "odrive-position": lambda **options: odrive_rig(mode="position", **options),
    "odrive-velocity": lambda **options: odrive_rig(mode="velocity", **options),
    "dynamixel-position": dynamixel_rig,
    "dynamixel-velocity": lambda **options: dynamixel_rig(mode="velocity", **options),
    "simulated": sim_rig,
}
SPEED = 0.4


WIRED = ContactSettings(joint="q2", bit=19)


class ServoBench:
    """A servo rig as the suites of single devices have it."""

    def __init__(self, make, **options):
        self.rig = make(stop_contact=WIRED, **options)
        self.device, self.run = self.rig.driver, self.rig.run
        self.rig.start()

    def inject(self, fault, value=None):
        self.rig.inject("arm", fault, value)


class TestEmergencyStop(EmergencyStopSuite):
    @pytest.fixture(params=["cia402-csp", "cia402-csv", "simulated"])
    def bench(self, request):
        return ServoBench(IMPLEMENTATIONS[request.param])


@pytest.mark.parametrize("active_low", [True, False])
@pytest.mark.parametrize("bit", [0, 16, 31])
def test_the_contact_is_read_at_its_bit_of_one_drive(bit, active_low):
    wired = ContactSettings(joint="q2", bit=bit, active_low=active_low)
    rig = cia402_rig(stop_contact=wired)
    assert rig.driver.emergency_stop().value, "until it is seen closed"
    rig.start()
    assert not rig.driver.emergency_stop().value
    rig.inject("arm.q2", "emergency_stop")
    rig.run(2)
    reading = rig.driver.emergency_stop()
    assert reading.value
    assert rig.clock.now() - reading.t <= 2.0 * PERIOD + 1e-9
    assert not any("emergency_stop" in fault for fault in rig.side.nodes[0].known_faults)


def test_a_drive_without_a_contact_is_never_taken_for_released():
    rig = cia402_rig()
    rig.start()
    assert rig.driver.emergency_stop().value
    assert rig.driver.was_pressed()
    with pytest.raises(ValueError, match="stop_contact: there is no joint q7"):
        cia402_rig(stop_contact=ContactSettings(joint="q7"))


@pytest.fixture(params=IMPLEMENTATIONS)
def make(request):
    return IMPLEMENTATIONS[request.param]


@pytest.fixture
def rig(make):
    made = make()
    made.start()
    return made


def move(rig, cycles, speed=SPEED):
    """Move every joint by positions, from the last setpoint on."""
    targets = getattr(rig, "targets", None) or list(rig.driver.positions().value)
    rig.targets = targets

    def command(_):
        for k, target in enumerate(targets):
            targets[k] = target + speed * PERIOD
        rig.driver.command_positions(tuple(targets))

    rig.run(cycles, command)


def test_names_and_shapes(rig):
    driver = rig.driver
    assert driver.name == "arm"
    assert driver.axis_names == ("q1", "q2")
    for reading in (driver.positions(), driver.velocities()):
        assert isinstance(reading, Reading)
        assert [type(value) for value in reading.value] == [float, float]


def test_nothing_is_energised_by_connecting(make):
    rig = make()
    rig.open()
    assert rig.plant.powered == [False, False]
    assert not rig.driver.is_enabled


def test_commands_before_arming_are_ignored(make):
    rig = make()
    rig.open()
    rig.driver.command_positions((0.5, 0.5))
    rig.driver.command_velocities((0.5, 0.5))
    rig.driver.set_torque_enabled(True)
    rig.clock.sleep_until(rig.clock.now() + 0.02)
    assert rig.plant.angles == [0.0, 0.0]
    assert rig.plant.powered == [False, False]


def test_arming_holds_the_joints_where_they_are(make):
    plant = LaggedJoints(2, start=0.6, fall=0.0)
    rig = make(plant=plant)
    rig.start()
    rig.run(40, lambda k: rig.driver.command_positions(rig.driver.positions().value))
    assert plant.powered == [True, True]
    assert plant.angles == pytest.approx([0.6, 0.6], abs=2e-3)


def test_the_first_command_makes_no_bump(make):
    plant = LaggedJoints(2, start=-0.3)
    rig = make(plant=plant)
    rig.start()
    held = rig.driver.positions().value
    fastest = 0.0
    for k in range(60):
        target = tuple(q + 1e-4 * k for q in held)
        rig.cycle(lambda target=target: rig.driver.command_positions(target))
        fastest = max(fastest, *map(abs, plant.speeds))
    assert fastest < 0.3, "a bump would be a step of the whole angle"


def test_positions_move_the_joints(rig):
    move(rig, 100)
    expected = 100 * PERIOD * SPEED
    assert rig.plant.angles == pytest.approx([expected, expected], abs=0.03)
    assert rig.driver.positions().value == pytest.approx(rig.plant.angles, abs=0.02)
    assert rig.driver.velocities().value == pytest.approx((SPEED, SPEED), abs=0.15)


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_velocities_move_the_joints(rig, speed):
    rig.run(100, lambda k: rig.driver.command_velocities((speed, -speed)))
    expected = 100 * PERIOD * speed
    assert rig.plant.angles == pytest.approx([expected, -expected], abs=0.03)


def test_each_joint_has_its_own_setpoint(rig):
    rig.run(60, lambda k: rig.driver.command_velocities((SPEED, 0.0)))
    assert rig.plant.angles[0] == pytest.approx(60 * PERIOD * SPEED, abs=0.03)
    assert rig.plant.angles[1] == pytest.approx(0.0, abs=5e-3)


def test_readings_are_old_by_a_cycle_or_two_and_never_go_back(rig):
    times = []
    for _ in range(20):
        rig.cycle()
        now = rig.clock.now()
        times.append(rig.driver.positions().t)
        assert 0.0 <= now - times[-1] <= 2.5 * PERIOD
    assert times == sorted(times)
    assert len(set(times)) > 15


def test_without_commands_the_joints_stay(rig):
    rig.run(20, lambda k: rig.driver.command_velocities((SPEED, SPEED)))
    rig.run(1, lambda k: rig.driver.command_velocities((0.0, 0.0)))
    rig.run(30)
    stood = list(rig.plant.angles)
    rig.run(40)
    assert rig.plant.angles == pytest.approx(stood, abs=0.01)


@pytest.mark.parametrize("bad", [(9.0, 0.0), (0.0, -9.0), (float("nan"), 0.0)])
def test_positions_that_no_program_should_send_are_refused(rig, bad):
    with pytest.raises(LimitExceeded, match=r"arm joint q[12]: position setpoint"):
        rig.driver.command_positions(bad)
    rig.run(20)
    assert rig.plant.angles == pytest.approx([0.0, 0.0], abs=5e-3)


@pytest.mark.parametrize("bad", [(99.0, 0.0), (0.0, float("nan")), (float("-inf"), 0.0)])
def test_velocities_that_no_program_should_send_are_refused(rig, bad):
    with pytest.raises(LimitExceeded, match=r"arm joint q[12]: velocity setpoint"):
        rig.driver.command_velocities(bad)
    rig.run(20)
    assert rig.plant.angles == pytest.approx([0.0, 0.0], abs=5e-3)


def test_make_safe_stops_the_joints_and_keeps_hold_of_them(rig):
    move(rig, 60)
    rig.safe_cycles(60)
    assert rig.plant.speeds == pytest.approx([0.0, 0.0], abs=5e-3)
    assert rig.plant.powered == [True, True]
    stood = list(rig.plant.angles)
    rig.driver.command_positions(tuple(q + 0.1 for q in stood))
    rig.safe_cycles(20)
    assert rig.plant.angles == pytest.approx(stood, abs=5e-3)


def test_torque_off_lets_go_and_on_again_takes_hold(rig):
    rig.driver.set_torque_enabled(False)
    rig.run(60)
    assert rig.plant.powered == [False, False]
    rig.driver.command_velocities((SPEED, SPEED))
    rig.run(10)
    assert rig.plant.angles == pytest.approx([0.0, 0.0], abs=5e-3)
    rig.driver.set_torque_enabled(True)
    rig.run(60)
    assert rig.plant.powered == [True, True]
    rig.run(40, lambda k: rig.driver.command_velocities((SPEED, SPEED)))
    assert rig.plant.angles == pytest.approx([40 * PERIOD * SPEED] * 2, abs=0.03)


def test_it_can_be_made_safe_and_closed_in_any_state_and_again(make):
    rig = make()
    for _ in range(2):
        rig.driver.make_safe()
        rig.driver.close()
    rig = make()
    rig.open()
    rig.driver.make_safe()
    rig.driver.close()
    rig.bus.make_safe()
    rig.bus.close()
    rig.driver.make_safe()
    rig.driver.close()
    rig.bus.close()


def test_a_second_start_after_a_stop(rig):
    move(rig, 20)
    rig.safe_cycles(40)
    rig.driver.close()
    rig.driver.connect()
    rig.driver.arm()
    rig.run(60)
    assert rig.driver.is_enabled
    rig.run(20, lambda k: rig.driver.command_velocities((0.0, 0.0)))
    assert rig.plant.speeds == pytest.approx([0.0, 0.0], abs=5e-3)


def test_a_silent_joint_is_a_fault_or_its_reading_grows_old(rig):
    rig.run(5)
    rig.inject("arm", "q2.silent")
    with pytest.raises(DeviceFault, match="q2"):
        for _ in range(100):
            rig.cycle()
            if rig.clock.now() - rig.driver.positions().t > 0.1:
                raise DeviceFault("arm joint q2", "grew old, which the mechanism refuses")


def test_a_blocked_joint_is_found_and_named(rig):
    rig.plant.blocked.add(1)
    with pytest.raises(DeviceError, match="q2"):
        for _ in range(200):
            move(rig, 1, 1.0)
