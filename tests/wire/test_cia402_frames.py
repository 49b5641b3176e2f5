"""A CiA 402 drive byte by byte: the start, the enabling, setpoints and feedback."""

import pytest
from cia402_bench import Drive


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
        "603#238060006E000000",  # a motor speed of 110 turns per minute, 15 % above 1 rad/s
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
    sampled = arm.bus.syncs.time
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
