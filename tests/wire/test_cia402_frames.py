"""A CiA 402 drive byte by byte: the start, the state machine, setpoints, and what may be wrong."""

import struct
from dataclasses import fields

import pytest
from scripted_bus import Bench, ScriptedNode, common_objects, u8, u16, u32

from drivers.canopen.bus import CanopenBus
from drivers.servos.cia402 import Cia402Servos
from drivers.servos.cia402_errors import describe_error
from drivers.servos.cia402_settings import Cia402Settings, DriveSettings
from drivers.servos.cia402_setup import encode_interpolation_period
from drivers.servos.cia402_states import DriveState, Goal, decode_state, next_control
from rig.hal import ConnectionFailed, DeviceFault, LimitExceeded

PERIOD = 0.005
# 1000 counts for a radian of the joint
DRIVE = {
    "node": 3,
    "counts_per_turn": 2 * 3.141592653589793 * 100.0,
    "gear": 10.0,
    "limits": (-1.0, 2.0),
    "max_speed": 1.0,
    "deceleration": 4.0,
    "following_window": 0.05,
    "following_time": 0.02,
}
OBJECTS = {
    (0x603F, 0): u16(0),
    (0x6040, 0): u16(0),
    (0x6041, 0): u16(0x0240),
    **{(index, 0): u16(0) for index in (0x605A, 0x605B, 0x605C, 0x605D, 0x605E, 0x6007, 0x6066)},
    (0x6060, 0): u8(0),
    (0x6065, 0): u32(0),
    (0x6076, 0): u32(2000),
    (0x607D, 1): u32(0),
    (0x607D, 2): u32(0),
    (0x6084, 0): u32(0),
    (0x6085, 0): u32(0),
    (0x60C2, 1): u8(1),
    (0x60C2, 2): u8(0xFD),
    (0x6502, 0): u32(0x180),
}


def status(word, position=0, mode=8):
    return f"183#{struct.pack('<Hib', word, position, mode).hex()}"


def feedback(velocity=0, torque=0, error=0):
    return f"283#{struct.pack('<ihH', velocity, torque, error).hex()}"


class DriveNode(ScriptedNode):
    """Sends all the PDOs of a sample at a SYNC."""

    at_sync = ()

    def receive(self, can_id, data):
        super().receive(can_id, data)
        if can_id == 0x80:
            self.bus.put(*self.at_sync)
            self.at_sync = ()


class Drive(Bench):
    def __init__(self, device_type=0x00020192, **settings):
        super().__init__()
        self.bus = CanopenBus("can0", self.settings, lambda: self.interface, self.clock, PERIOD)
        self.bus.open()
        self.node = DriveNode(self.interface, 3, common_objects(device_type) | OBJECTS)
        names = [field.name for field in fields(DriveSettings)]
        own = {key: settings.pop(key) for key in list(settings) if key in names}
        joints = {"elbow": DriveSettings(**(DRIVE | own))}
        self.driver = Cia402Servos("arm", Cia402Settings(joints=joints, **settings), self.bus)

    def connect(self):
        self.driver.connect()
        return self.sent()

    def start(self, position=0):
        """Arm, and answer each control word as a drive does."""
        self.connect()
        self.arm(position)
        for word in (0x0240, 0x0221, 0x0223, 0x1227):
            self.run(word, position)
        assert self.driver.is_enabled
        self.sent()

    def arm(self, position=0, mode=8):
        self.node.at_sync = (status(0x0240, position, mode), feedback())
        self.driver.arm()
        return self.sent()

    def run(self, word=0x1227, position=0, mode=8, command=None, extra=(), **fed):
        """One cycle in which the drive answers with a status word; return what was sent."""
        self.interface.put(status(word, position, mode), feedback(**fed), "703#05", *extra)
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        self.bus.check(now)
        if command is not None:
            command()
        self.bus.transmit(now)
        self.clock.sleep_until(now + PERIOD)
        return [frame for frame in self.sent() if not frame.startswith("77F")]


@pytest.fixture
def arm():
    bench = Drive()
    bench.start()
    return bench


def test_the_start_sends_these_frames_in_this_order():
    writes = [frame for frame in Drive().connect() if not frame.startswith("603#40")]
    assert writes == [
        "000#8103",
        "603#2B17100032000000",  # heartbeat every 50 ms
        "603#2316100196007F00",  # the master's, 150 ms
        "603#2B5A600006000000",  # quick stop: ramp, then hold
        "603#2B5B600001000000",  # shutdown: ramp
        "603#2B5C600001000000",  # disable operation: ramp
        "603#2B5D600001000000",  # halt: ramp
        "603#2B5E600002000000",  # fault: quick-stop ramp
        "603#2B07600003000000",  # master lost: quick stop
        "603#2365600032000000",  # following error window: 50 counts
        "603#2B66600014000000",  # for 20 ms
        "603#237D600118FCFFFF",  # -1000 counts
        "603#237D6002D0070000",  # 2000 counts
        "603#23846000A00F0000",  # 4000 counts/s²
        "603#23856000A00F0000",
        "603#2FC2600105000000",  # 5
        "603#2FC26002FD000000",  # · 10^-3 s
        "603#2F60600008000000",  # csp
        "603#2F29100100000000",
        "603#23001401030200C0",
        "603#2F00160000000000",
        "603#2300160110004060",
        "603#2300160220007A60",
        "603#2300160308006060",
        "603#2F00160003000000",
        "603#2F00140201000000",
        "603#2300140103020040",
        "603#23001801830100C0",
        "603#2F001A0000000000",
        "603#23001A0110004160",
        "603#23001A0220006460",
        "603#23001A0308006160",
        "603#2F001A0003000000",
        "603#2F00180201000000",
        "603#2300180183010040",
        "603#23011801830200C0",
        "603#2F011A0000000000",
        "603#23011A0120006C60",
        "603#23011A0210007760",
        "603#23011A0310003F60",
        "603#2F011A0003000000",
        "603#2F01180201000000",
        "603#2301180183020040",
    ]


def test_the_state_machine_goes_one_transition_at_a_time_and_repeats_each():
    bench = Drive()
    bench.connect()
    assert bench.arm(500) == ["000#0103", "203#00000000000008", "080#"]
    hold = "F401000008"
    walk = [
        (0x0240, "0600"),
        (0x0240, "0600"),  # the drive did not hear it, or has not answered yet
        (0x0221, "0700"),
        (0x0223, "0F00"),
        (0x0223, "0F00"),
    ]
    for word, control in walk:
        assert not bench.driver.is_enabled
        assert bench.run(word, 500) == [f"203#{control}{hold}", "080#"]
    bench.run(0x1227, 500)
    assert bench.driver.is_enabled


def test_targets_before_the_drives_are_enabled_are_not_sent():
    bench = Drive()
    bench.connect()
    bench.arm(500)
    for word in (0x0240, 0x0221, 0x0223):
        frame, *_ = bench.run(word, 500, command=lambda: bench.driver.command_positions((1.9,)))
        assert frame.endswith("F401000008")


def test_a_position_is_scaled_rounded_and_sent_before_sync(arm):
    command = arm.driver.command_positions
    assert arm.run(command=lambda: command((0.0034,))) == ["203#0F000300000008", "080#"]
    assert arm.run(command=lambda: command((-0.0016,))) == ["203#0F00FEFFFFFF08", "080#"]


def test_positions_velocities_and_torques_are_decoded(arm):
    arm.run(0x1227, -4, velocity=-250, torque=100)
    sampled = arm.bus.sync_time
    arm.run(0x1227, -5, velocity=-250, torque=100)
    assert arm.driver.positions().value == pytest.approx((-0.005,))
    assert arm.driver.positions().t == pytest.approx(sampled)
    assert arm.driver.velocities().value == pytest.approx((-0.25,))
    assert arm.driver.torques().value == pytest.approx((0.1 * 2.0 * 10.0,))


def test_a_reversed_joint_with_an_offset_counts_down():
    bench = Drive(reversed=True, offset=0.5)
    assert "603#237D600124FAFFFF" in bench.connect()  # the upper limit of 2.0 rad: -1500 counts
    bench = Drive(reversed=True, offset=0.5)
    bench.start(position=200)
    assert bench.driver.positions().value == pytest.approx((0.3,))
    frame, *_ = bench.run(position=200, command=lambda: bench.driver.command_positions((0.301,)))
    assert frame == "203#0F00C700000008"


def test_velocities_in_csv_and_the_hold_of_a_position():
    bench = Drive(mode="csv", position_gain=10.0)
    bench.connect()
    bench.arm(500, mode=9)
    for word in (0x0240, 0x0221, 0x0223, 0x1227):
        frame, *_ = bench.run(word, 500, 9)
        assert frame.endswith("0000000009"), "no velocity before it is enabled"
    command = bench.driver.command_velocities
    assert bench.run(position=500, mode=9, command=lambda: command((0.3,)))[0] == (
        "203#0F002C01000009"
    )
    # it creeps by 2 counts while it is to stand still: 2e-3 rad · 10 /s = 20 counts/s back
    bench.run(position=501, mode=9, command=lambda: command((0.0,)))
    frame, *_ = bench.run(position=503, mode=9, command=lambda: command((0.0,)))
    assert frame == "203#0F00ECFFFFFF09"


def test_the_safe_state_is_a_quick_stop_with_the_last_target(arm):
    arm.run(command=lambda: arm.driver.command_positions((0.003,)))
    arm.driver.make_safe()
    arm.bus.transmit(arm.clock.now())
    assert "203#02000300000008" in arm.sent()
    arm.driver.command_positions((0.004,))
    arm.bus.make_safe()
    assert "203#02000300000008" in arm.sent(), "a command after it changes nothing"


def test_torque_off_goes_by_way_of_switched_on(arm):
    arm.driver.set_torque_enabled(False)
    words = [arm.run(word)[0][4:8] for word in (0x1227, 0x0223, 0x0221, 0x0240)]
    assert words == ["0700", "0600", "0000", "0000"]
    arm.driver.set_torque_enabled(True)
    words = [arm.run(word)[0][4:8] for word in (0x0240, 0x0221, 0x0223)]
    assert words == ["0600", "0700", "0F00"]


STATES = [
    (0x0000, "NOT_READY"),
    (0x0250, "SWITCH_ON_DISABLED"),
    (0x0270, "SWITCH_ON_DISABLED"),
    (0x0231, "READY_TO_SWITCH_ON"),
    (0x0233, "SWITCHED_ON"),
    (0x1637, "OPERATION_ENABLED"),
    (0x0217, "QUICK_STOP_ACTIVE"),
    (0x021F, "FAULT_REACTION_ACTIVE"),
    (0x023F, "FAULT_REACTION_ACTIVE"),
    (0x0218, "FAULT"),
    (0x0238, "FAULT"),
]


@pytest.mark.parametrize(("word", "name"), STATES)
def test_states_of_status_words(word, name):
    assert decode_state(word) is DriveState[name]


def test_every_status_word_reads_as_the_canopen_package_reads_it():
    p402 = pytest.importorskip("canopen.profiles.p402")
    for word in range(0x80):
        theirs = next(
            (n for n, (mask, bits) in p402.State402.SW_MASK.items() if word & mask == bits), None
        )
        ours = decode_state(word)
        spelled = {"NOT READY TO SWITCH ON": "NOT_READY"}
        if theirs is None:
            assert ours is None, hex(word)
        else:
            assert ours is not None, hex(word)
            assert ours.name == spelled.get(theirs, theirs.replace(" ", "_"))


def test_no_control_word_resets_a_fault():
    for goal in Goal:
        for state in (*DriveState, None):
            assert not next_control(state, goal) & 0x80


@pytest.mark.parametrize(
    ("period", "expected"),
    [
        (0.005, (5, -3)),
        (0.001, (1, -3)),
        (0.0025, (25, -4)),
        (1 / 400, (25, -4)),
        (0.25, (250, -3)),
    ],
)
def test_the_interpolation_period_is_exact(period, expected):
    assert encode_interpolation_period(period) == expected


@pytest.mark.parametrize("period", [1 / 300, 0.3, 1e-7])
def test_a_period_that_drives_cannot_be_told_is_refused(period):
    with pytest.raises(ValueError, match=r"0x60C2 holds.*another rate"):
        encode_interpolation_period(period)


# What may be wrong while it is connected -------------------------------------------------


def test_another_kind_of_device_is_refused():
    with pytest.raises(ConnectionFailed, match=r"arm joint elbow \(node 0x03\).*another kind"):
        Drive(device_type=0x000F0191).connect()
    with pytest.raises(ConnectionFailed, match="frequency converter"):
        Drive(device_type=0x00010192).connect()


@pytest.mark.parametrize(
    ("objects", "message"),
    [
        ({(0x6502, 0): u32(0x100)}, r"does not know the mode csp.*0x6502.*bit 7"),
        ({(0x6092, 1): u32(4000), (0x6092, 2): u32(1)}, r"position unit.*4000 counts per turn"),
        (
            {
                (0x608F, 1): u32(400),
                (0x608F, 2): u32(1),
                (0x6091, 1): u32(3),
                (0x6091, 2): u32(1),
            },
            r"position unit.*1200 counts per turn",
        ),
    ],
)
def test_wrong_modes_and_units_are_refused(objects, message):
    bench = Drive()
    bench.node.objects |= objects
    with pytest.raises(ConnectionFailed, match=message):
        bench.connect()


def test_a_right_unit_is_accepted():
    bench = Drive(counts_per_turn=4096.0)
    bench.node.objects |= {(0x6092, 1): u32(8192), (0x6092, 2): u32(2)}
    bench.connect()


@pytest.mark.parametrize("index", [0x605A, 0x605E, 0x6007, 0x607D, 0x6085, 0x60C2, 0x6065])
def test_a_safety_setting_that_is_not_kept_is_named(index):
    bench = Drive()
    sub = 1 if index in (0x607D, 0x60C2) else 0
    bench.node.stubborn.add((index, sub))
    bench.node.objects[index, sub] = bytes(len(bench.node.objects[index, sub]))
    with pytest.raises(ConnectionFailed, match=rf"reads back another.*0x{index:04X}:{sub:02X}"):
        bench.connect()


def test_a_setting_that_is_refused_is_named_unless_the_profile_knows_that_it_is_absent():
    bench = Drive()
    del bench.node.objects[0x605B, 0]
    with pytest.raises(ConnectionFailed, match=r"refused.*0x605B:00"):
        bench.connect()
    bench = Drive(absent=(0x605B,))
    del bench.node.objects[0x605B, 0]
    assert not [frame for frame in bench.connect() if "5B60" in frame]


def test_an_offset_that_somebody_left_is_cleared():
    bench = Drive()
    bench.node.objects |= {(0x60B1, 0): u32(77), (0x60B2, 0): u16(5)}
    bench.connect()
    assert bench.node.objects[0x60B1, 0] == bytes(4)
    assert bench.node.objects[0x60B2, 0] == bytes(2)


def test_a_drive_in_a_fault_is_refused_in_words():
    bench = Drive()
    bench.node.objects |= {
        (0x1001, 0): u8(0x21),
        (0x603F, 0): u16(0x3210),
        (0x6041, 0): u16(0x0218),
    }
    with pytest.raises(ConnectionFailed) as caught:
        bench.connect()
    text = str(caught.value)
    for part in ("joint elbow", "node 0x03", "over-voltage of the DC link", "0x3210", "0x0218"):
        assert part in text


def test_a_joint_outside_its_limits_is_not_energised():
    bench = Drive()
    bench.connect()
    with pytest.raises(ConnectionFailed, match=r"outside its limits.*2.1 rad.*-1 … 2 rad"):
        bench.arm(2100)


# What may be wrong while it runs ---------------------------------------------------------


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
        ("command_positions", (2.5,), r"joint elbow: position setpoint is 2.5 rad"),
        ("command_positions", (float("nan"),), "position setpoint is nan"),
        ("command_positions", (0.0051,), r"0.0051 rad, outside -0.005 rad … 0.005 rad"),
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
    arm.interface.put("183#", is_remote_frame=True)
    arm.run(position=0)
    assert arm.driver.positions().value == (0.0,)
    assert arm.driver.statistics()["wrong_length"] == 2


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


# Settings --------------------------------------------------------------------------------


def joint(**changes):
    return DriveSettings(**(DRIVE | changes))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: joint(limits=(1.0, -1.0)), "no range of angles"),
        (lambda: joint(offset=1e9), "32-bit position"),
        (lambda: Cia402Settings(joints={"a": joint(), "b": joint()}), "joints a and b.*0x03"),
        (
            lambda: Cia402Settings(joints={"a": joint()}, feedback=("torque", "torque")),
            "named twice",
        ),
        (lambda: Cia402Settings(joints={"a": joint()}, hold_after=9), "fault_after"),
    ],
)
def test_settings_that_cannot_be_right_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_bus_without_a_period_is_refused():
    bench = Bench()
    with pytest.raises(ValueError, match="no period"):
        Cia402Servos("arm", Cia402Settings(joints={"a": joint()}), bench.bus)


def test_error_codes_fall_back_to_their_group():
    assert describe_error(0x8611) == "following error too large"
    assert describe_error(0x86FF) == "positioning"
    assert describe_error(0x3299) == "voltage inside the device"
