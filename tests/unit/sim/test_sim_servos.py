"""Simulated servo joints on a plant that only remembers, and faults that are addressed by joint."""

import pytest

from drivers.servos.axis_settings import FollowingAxisSettings
from drivers.sim.axis_faults import AxisFaults
from drivers.sim.clock import SimClock
from drivers.sim.direct.servos import SimulatedServos
from rig.hal import DeviceFault

PERIOD = 5e-3
JOINT = FollowingAxisSettings(
    limits=(-1.0, 1.0), deceleration=4.0, following_window=0.05, following_time=0.02
)


class Remembering:
    """Joints that stand where a test puts them."""

    def __init__(self):
        self.angles = [0.1, 0.2]
        self.calls = []
        self.time = 0.0

    def advance(self, t):
        self.time = t

    def command_joint(self, channel, position, velocity, torque_on):
        self.calls.append((channel, position, velocity, torque_on))

    def limit_joint(self, channel, speed, torque):
        pass

    def joint_position(self, channel):
        return self.angles[channel]

    def joint_velocity(self, channel):
        return 0.25

    def joint_torque(self, channel):
        return 1.5


@pytest.fixture
def plant():
    return Remembering()


@pytest.fixture
def clock(plant):
    return SimClock(plant)


@pytest.fixture
def servos(plant, clock):
    device = SimulatedServos(
        "arm",
        dict.fromkeys(("q1", "q2"), JOINT),
        plant,
        (0, 1),
        clock,
        resolutions=(1e-3, 1e-2),
    )
    device.connect()
    device.arm()
    return device


def cycle(servos, clock, *positions):
    now = clock.now()
    servos.check(now)
    if positions:
        servos.command_positions(positions)
    clock.sleep_until(now + PERIOD)


def last(plant, channel):
    return next(call[1:] for call in reversed(plant.calls) if call[0] == channel)


def test_readings_are_quantised_and_one_cycle_old(servos, clock, plant):
    cycle(servos, clock)
    plant.angles[:] = [0.12345, 0.12345]
    cycle(servos, clock)
    assert servos.positions().value == pytest.approx((0.123, 0.12))
    assert servos.positions().t == pytest.approx(clock.now() - PERIOD)
    plant.angles[:] = [0.5, 0.5]
    assert servos.positions().value == pytest.approx((0.123, 0.12))
    assert servos.velocities().value == (0.25, 0.25)
    assert servos.torques().value == (1.5, 1.5)


def test_a_setpoint_is_a_straight_line_of_one_period(servos, clock, plant):
    cycle(servos, clock)
    cycle(servos, clock, 0.101, 0.198)
    assert last(plant, 0) == pytest.approx((0.1, 0.2, True))
    assert last(plant, 1) == pytest.approx((0.2, -0.4, True))
    cycle(servos, clock, 0.101, 0.198)
    assert last(plant, 0) == pytest.approx((0.101, 0.0, True))


def test_a_stop_is_a_ramp(servos, clock, plant):
    cycle(servos, clock)
    for k in range(1, 5):
        plant.angles[:] = [0.1 + 0.002 * k, 0.2]
        cycle(servos, clock, 0.1 + 0.002 * k, 0.2)
    speeds = []
    for _ in range(25):
        servos.make_safe()
        speeds.append(last(plant, 0)[1])
    assert speeds[:2] == pytest.approx([0.39, 0.37])
    assert speeds[-4:] == [0.0] * 4
    assert last(plant, 0)[0] == pytest.approx(0.108 + 0.4**2 / 2.0 / 4.0)
    assert last(plant, 0)[2]


def test_a_fault_of_one_joint_names_it(servos, clock, plant):
    cycle(servos, clock)
    servos.inject("q2.drive_fault")
    assert last(plant, 1)[2] is False
    with pytest.raises(DeviceFault, match="arm joint q2: the drive reports a fault"):
        cycle(servos, clock)
    servos.inject("q2.repair")
    cycle(servos, clock)


def test_a_joint_that_stays_behind_is_found(servos, clock):
    cycle(servos, clock)
    with pytest.raises(DeviceFault, match=r"q1: the joint does not follow.*\+0\.\d+ rad"):
        for k in range(40):
            cycle(servos, clock, 0.1 + 0.005 * k, 0.2)


def test_a_stuck_joint_gets_no_more_references(servos, clock, plant):
    cycle(servos, clock)
    servos.inject("q1.stuck")
    plant.calls.clear()
    cycle(servos, clock, 0.101, 0.201)
    assert {call[0] for call in plant.calls} == {1}


def test_a_silent_joint_holds_its_reading_for_a_while(servos, clock, plant):
    cycle(servos, clock)
    servos.inject("q1.silent", 2 * PERIOD)
    plant.angles[:] = [0.3, 0.3]
    cycle(servos, clock)
    assert servos.positions().value == pytest.approx((0.1, 0.3))
    assert servos.positions().t < clock.now() - PERIOD
    for _ in range(4):
        cycle(servos, clock)
    assert servos.positions().value == pytest.approx((0.3, 0.3))


def test_an_encoder_that_jumps(servos, clock):
    cycle(servos, clock)
    servos.inject("q1.encoder_jump", 0.2)
    cycle(servos, clock)
    assert servos.positions().value == pytest.approx((0.3, 0.2))


@pytest.mark.parametrize(
    ("fault", "value", "message"),
    [
        ("q3.stuck", None, "no joint 'q3'.*q1, q2"),
        ("q1.blown", None, "no fault 'blown'"),
        ("blown", None, "no fault 'blown'"),
        ("q1.silent", -1.0, "lasts longer"),
    ],
)
def test_faults_that_are_not_known_are_refused(servos, fault, value, message):
    with pytest.raises(ValueError, match=message):
        servos.inject(fault, value)


def test_faults_may_befall_all_joints(servos, clock):
    servos.inject("drive_fault")
    with pytest.raises(DeviceFault, match="q1"):
        cycle(servos, clock)
    known = servos.known_faults
    assert "stuck" in known
    assert "q2.stuck" in known
    assert len(set(known)) == len(known)
    assert AxisFaults("arm", {}).known_faults == ()
