"""The emulated CiA 402 drive by itself: option codes, limits and following error."""

import random
import struct

import pytest
from servo_bench import LaggedJoints

from drivers.sim.nodes.cia402 import EmulatedCia402
from drivers.sim.nodes.drive_states import State
from drivers.sim.nodes.motion_reference import MotionReference
from drivers.sim.nodes.object_dictionary import SdoAbortError

COUNTS = 10_000
RADIAN = COUNTS / 6.283185307179586
SHUTDOWN, SWITCH_ON, ENABLE, QUICK_STOP, DISABLE = 0x06, 0x07, 0x0F, 0x02, 0x00
LAYOUTS = {
    0x6040: "H",
    0x6060: "b",
    0x607A: "i",
    0x60FF: "i",
    0x6065: "I",
    0x6066: "H",
    0x6072: "H",
    0x6080: "I",
    0x6084: "I",
    0x6085: "I",
    0x607D: "i",
    0x60C2: "B",
}


class Drive:
    """One drive in OPERATIONAL, written to as by SDO."""

    def __init__(self):
        self.plant = LaggedJoints(1, lag=0.002, fall=0.5)
        self.node = EmulatedCia402("drive", 1, self.plant, 0, counts_per_turn=COUNTS)
        self.time = 0.0
        self.frames = []
        self.node.send = lambda can_id, data: self.frames.append((can_id, data))
        self.run(0.001)
        self.node.receive(0x000, b"\x01\x00", self.time)
        self.write(0x6084, 20 * RADIAN)
        self.write(0x6085, 50 * RADIAN)

    def write(self, index, value, sub=0):
        layout = LAYOUTS.get(index, "h")
        self.node.dictionary.write(index, sub, struct.pack(f"<{layout}", round(value)))

    def read(self, index, sub=0):
        data = self.node.dictionary.read(index, sub)
        return int.from_bytes(data, "little", signed=index in (0x6061, 0x6064, 0x606C, 0x60F4))

    def run(self, seconds):
        end = self.time + seconds
        while self.node.due <= end:
            self.time = max(self.node.due, self.time)
            self.plant.advance(self.time)
            self.node.tick(self.time)
        self.time = end
        self.plant.advance(end)
        self.node.now = end

    def enable(self, mode=9):
        self.write(0x6060, mode)
        for word in (SHUTDOWN, SWITCH_ON, ENABLE):
            self.write(0x6040, word)
        assert self.state is State.ENABLED

    def spin(self, speed=1.0):
        self.enable()
        self.write(0x60FF, speed * RADIAN)
        self.run(0.1)
        assert self.plant.speeds[0] == pytest.approx(speed, rel=1e-2)

    @property
    def state(self):
        return self.node.machine.state

    def stop_time(self):
        """Return how long the joint takes to come to rest, and whether it has torque then."""
        begun = self.time
        while abs(self.plant.speeds[0]) > 0.02 and self.plant.powered[0]:
            self.run(0.001)
            assert self.time < begun + 1.0
        return self.time - begun


@pytest.fixture
def drive():
    return Drive()


@pytest.mark.parametrize(
    ("option", "time", "state", "powered"),
    [
        (0, 0.0, State.DISABLED, False),
        (1, 0.050, State.DISABLED, False),
        (2, 0.020, State.DISABLED, False),
        (5, 0.050, State.QUICK_STOP, True),
        (6, 0.020, State.QUICK_STOP, True),
    ],
)
def test_quick_stop_option(drive, option, time, state, powered):
    drive.write(0x605A, option)
    drive.spin()
    drive.write(0x6040, QUICK_STOP)
    assert drive.stop_time() == pytest.approx(time, abs=0.008)
    drive.run(0.02)
    assert drive.state is state
    assert drive.plant.powered == [powered]


def test_out_of_a_quick_stop_that_stays(drive):
    drive.write(0x605A, 6)
    drive.spin()
    drive.write(0x6040, QUICK_STOP)
    drive.run(0.1)
    drive.write(0x60FF, 0)
    drive.write(0x6040, ENABLE)  # transition 16
    assert drive.state is State.ENABLED
    drive.write(0x6040, QUICK_STOP)
    drive.write(0x6040, DISABLE)  # transition 12
    assert drive.state is State.DISABLED


@pytest.mark.parametrize(
    ("index", "word", "reached"),
    [(0x605B, SHUTDOWN, State.READY), (0x605C, SWITCH_ON, State.SWITCHED_ON)],
)
@pytest.mark.parametrize(("option", "time"), [(0, 0.0), (1, 0.050)])
def test_shutdown_and_disable_operation_options(drive, index, word, reached, option, time):
    drive.write(index, option)
    drive.spin()
    drive.write(0x6040, word)
    assert drive.stop_time() == pytest.approx(time, abs=0.008)
    drive.run(0.02)
    assert drive.state is reached
    assert drive.plant.powered == [False]


@pytest.mark.parametrize(("option", "time"), [(1, 0.050), (2, 0.020)])
def test_halt_option_stops_and_stays_enabled(drive, option, time):
    drive.write(0x605D, option)
    drive.spin()
    drive.write(0x6040, ENABLE | 0x0100)
    assert drive.stop_time() == pytest.approx(time, abs=0.008)
    assert drive.state is State.ENABLED
    drive.write(0x6040, ENABLE)
    drive.run(0.05)
    assert drive.plant.speeds[0] == pytest.approx(1.0, rel=1e-2)


@pytest.mark.parametrize(("option", "time"), [(0, 0.0), (1, 0.050), (2, 0.020)])
def test_fault_reaction_option(drive, option, time):
    drive.write(0x605E, option)
    drive.spin()
    drive.node.inject("drive_fault", 0x4310)
    assert drive.stop_time() == pytest.approx(time, abs=0.008)
    drive.run(0.02)
    assert drive.state is State.FAULT
    assert drive.read(0x603F) == 0x4310
    assert drive.plant.powered == [False]


@pytest.mark.parametrize(
    ("option", "state"),
    [
        (0, State.ENABLED),
        (1, State.FAULT),
        (2, State.DISABLED),
        (3, State.DISABLED),  # quick stop, option 2
    ],
)
def test_abort_connection_option(drive, option, state):
    drive.write(0x6007, option)
    drive.node.dictionary.write(0x1016, 1, struct.pack("<I", 0x7F << 16 | 100))
    drive.node.receive(0x77F, b"\x05", drive.time)
    drive.spin()  # takes 0.1 s, and no second heartbeat comes
    drive.run(0.2)
    assert drive.state is state
    assert drive.plant.powered == [state is State.ENABLED]
    assert (0x081, bytes.fromhex("3081117F00000000")) in drive.frames


def test_states_are_not_skipped_and_commands_out_of_order_ignored(drive):
    for word in (ENABLE, SWITCH_ON):
        drive.write(0x6040, word)
        assert drive.state is State.DISABLED
    drive.write(0x6040, SHUTDOWN)
    drive.write(0x6040, ENABLE)
    assert drive.state is State.SWITCHED_ON, "one transition for one word"
    drive.write(0x6040, ENABLE)
    assert drive.state is State.ENABLED


def test_a_fault_needs_a_rising_edge(drive):
    drive.node.inject("drive_fault")
    drive.run(0.01)
    drive.node.machine._word = 0x80
    drive.write(0x6040, 0x80)
    assert drive.state is State.FAULT
    drive.write(0x6040, 0x00)
    drive.write(0x6040, 0x80)
    assert drive.state is State.DISABLED
    assert drive.read(0x603F) == 0


def test_a_following_error_takes_its_time(drive):
    drive.write(0x6065, 100)
    drive.write(0x6066, 50)
    drive.enable(mode=8)
    drive.plant.blocked.add(0)
    drive.write(0x607A, 200)
    drive.run(0.045)
    assert drive.state is State.ENABLED
    assert drive.read(0x60F4) == pytest.approx(200, abs=2)
    drive.run(0.02)
    assert drive.state in (State.FAULT_REACTION, State.FAULT)
    assert drive.read(0x603F) == 0x8611
    assert drive.read(0x6041) & 0x2000


def test_positions_beyond_the_software_limit_are_not_gone_to(drive):
    drive.write(0x607D, -500, sub=1)
    drive.write(0x607D, 500, sub=2)
    drive.enable(mode=8)
    drive.write(0x607A, 700)
    drive.run(0.1)
    assert drive.read(0x6064) == pytest.approx(500, abs=1)
    assert drive.read(0x6041) & 0x0800
    drive.write(0x607A, 400)
    drive.run(0.1)
    assert not drive.read(0x6041) & 0x0800


def test_safe_torque_off_keeps_the_drive_disabled(drive):
    drive.spin()
    drive.node.inject("safe_torque_off")
    drive.run(0.01)
    assert drive.state is State.DISABLED
    assert not drive.read(0x6041) & 0x0010
    drive.write(0x6040, SHUTDOWN)
    assert drive.state is State.DISABLED
    drive.node.power_on()  # which closes no contact
    drive.run(0.1)
    drive.write(0x6040, SHUTDOWN)
    assert drive.state is State.DISABLED
    drive.node.inject("repair")
    drive.write(0x6040, SHUTDOWN)
    assert drive.state is State.READY


def test_values_that_the_drive_does_not_know_are_refused(drive):
    for index, value in ((0x605A, 3), (0x605E, 7), (0x6007, 4), (0x6060, 3)):
        with pytest.raises(SdoAbortError):
            drive.write(index, value)


# The reference ---------------------------------------------------------------------------


def test_interpolation_arrives_exactly_and_stands():
    motion = MotionReference()
    motion.interpolate(10.0, 0.005, 0.0)
    motion.advance(0.002)
    assert motion.position == pytest.approx(4.0)
    motion.advance(0.005)
    assert (motion.position, motion.velocity) == (10.0, 0.0)
    motion.advance(1.0)
    assert motion.position == 10.0


def test_a_ramp_from_cruising_takes_the_distance_that_physics_says():
    motion = MotionReference()
    motion.interpolate(5.0, 0.005, 0.0)  # 1000 a second
    motion.slow_down(4000.0, 0.005)
    for k in range(1, 300):
        motion.advance(0.005 + 0.001 * k)
    assert motion.position == pytest.approx(5.0 + 1000.0**2 / 2.0 / 4000.0)
    assert not motion.is_moving


def test_after_setpoints_stayed_away_there_is_nothing_to_slow_down():
    motion = MotionReference()
    motion.interpolate(5.0, 0.005, 0.0)
    motion.advance(0.02)
    motion.slow_down(4000.0, 0.02)
    assert not motion.is_moving


def test_without_a_ramp_it_stops_at_once():
    motion = MotionReference()
    motion.run(100.0, 0.0)
    motion.slow_down(0.0, 0.1)
    motion.advance(0.2)
    assert motion.position == pytest.approx(10.0)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("mode", [8, 9])
def test_its_motor_is_no_faster_than_it_was_told(mode, seed):
    chance = random.Random(seed)
    cap, asked = chance.uniform(0.2, 2.0), chance.uniform(2.5, 50.0)
    drive = Drive()
    drive.write(0x60C2, 5, 1)
    drive.write(0x6080, cap / 6.283185307179586 * 60.0 * 1000)  # in thousandths: see below
    drive.node._counts_per_turn = COUNTS / 1000  # whole turns per minute are coarse without a gear
    drive.enable(mode)
    fastest, target = 0.0, 0.0
    for _ in range(40):
        target += asked * 0.005
        drive.write(0x607A if mode == 8 else 0x60FF, (target if mode == 8 else asked) * RADIAN)
        drive.run(0.005)
        fastest = max(fastest, abs(drive.plant.speeds[0]))
    assert fastest == pytest.approx(cap, rel=0.05)
    assert drive.read(0x6041) & 1 << 11, "a limit inside the drive is active"


def test_its_motor_gives_no_more_torque_than_it_was_told():
    drive = Drive()
    drive.write(0x6072, 250)
    assert drive.plant.caps[0][1] == pytest.approx(0.25), "of a rated torque of 1 N m"
