"""The frames of an ODrive as the driver sends them, and a CANSimple bus on a raw socket."""

import socket
import struct

import pytest
from odrive_bench import PERIOD, Bench
from scripted_bus import ScriptedBus, TestClock

from drivers.can.cyclic import CyclicFrame
from drivers.can.socketcan import SocketCanBus
from drivers.odrive.bus import OdriveBus
from drivers.odrive.settings import OdriveBusSettings, OdriveEndpoints


def test_the_start_sends_these_frames_in_this_order():
    assert Bench(axis={"current_limit": 20.0}).connect() == [
        "400007E6#",  # remote: addresses of all
        "40000060#",  # remote: version
        "40000063#",  # remote: errors
        "067#0100000000000000",  # idle
        "06B#0300000001000000",  # position, passthrough
        "06F#3333933F0000A041",  # 1.15 turn/s, 20 A
    ]


def test_parameters_are_written_and_read_back():
    endpoints = OdriveEndpoints(enable_watchdog=7, watchdog_timeout=8)
    bench = Bench(endpoints=endpoints, watchdog=0.05)
    frames = bench.connect()
    assert [f for f in frames if f.startswith("064")] == [
        "064#01080000CDCC4C3D",
        "064#0008000000000000",
        "064#0107000001000000",
        "064#0007000000000000",
    ]
    assert bench.axis.endpoints[7] == b"\x01"


@pytest.mark.parametrize("size", [0, 4], ids=["as long as its type", "as in the manual"])
@pytest.mark.parametrize("confirms", [None, b"", bytes(4)], ids=["silent", "empty", "zeros"])
def test_answers_of_every_firmware_are_understood(size, confirms):
    """0.6.11 and later confirms a write by a TxSdo too; what that bears is not written down."""
    endpoints = OdriveEndpoints(enable_watchdog=7, watchdog_timeout=8)
    bench = Bench(endpoints=endpoints, watchdog=0.05)
    bench.axis.value_size, bench.axis.confirms = size, confirms
    bench.connect()
    assert bench.axis.endpoints[7] == b"\x01"
    assert bench.axis.endpoints[8] == struct.pack("<f", 0.05)


def test_setpoints_feed_the_watchdog_before_the_loop_is_closed():
    bench = Bench()
    bench.axis.turns = 0.25
    frames = bench.start()
    hold = f"06C#{struct.pack('<fhh', 0.25, 0, 0).hex().upper()}"
    mode, limits = "06B#0300000001000000", frames[1]
    assert limits.startswith("06F#")
    # With the limits, should it have rebooted since it was told them.
    assert frames[:5] == [mode, limits, "067#0800000000000000", hold, hold]
    assert set(frames[3:]) == {hold}
    assert frames.count("067#0800000000000000") == 1


def test_a_position_goes_out_with_its_velocity_as_feedforward():
    bench = Bench()
    bench.start()
    frames = bench.cycle(lambda: bench.driver.command_positions((0.004,)))
    assert frames == [f"06C#{struct.pack('<fhh', 0.004, 800, 0).hex().upper()}"]
    bench = Bench(feedforward=False)
    bench.start()
    frames = bench.cycle(lambda: bench.driver.command_positions((0.004,)))
    assert frames == [f"06C#{struct.pack('<fhh', 0.004, 0, 0).hex().upper()}"]


def test_a_reversed_joint_with_an_offset():
    bench = Bench(axis={"reversed": True, "offset": 0.5})
    bench.axis.turns = 0.2
    bench.start()
    assert bench.driver.positions().value == pytest.approx((0.3,))
    frames = bench.cycle(lambda: bench.driver.command_positions((0.302,)))
    assert frames == [f"06C#{struct.pack('<fhh', 0.198, -400, 0).hex().upper()}"]


def test_a_velocity_in_velocity_mode():
    bench = Bench(mode="velocity")
    assert "06B#0200000001000000" in bench.connect()
    bench.start()
    assert bench.cycle(lambda: bench.driver.command_velocities((0.5,))) == ["06D#0000003F00000000"]


def test_the_safe_state_ramps_the_setpoint_down():
    bench = Bench()
    bench.start()
    for k in range(1, 21):
        bench.axis.turns = 0.004 * k
        bench.cycle(lambda k=k: bench.driver.command_positions((0.004 * k,)))
    speeds = []
    for _ in range(45):
        bench.driver.make_safe()
        bench.bus.transmit(bench.clock.now())
        (only,) = bench.sent()
        position, steps, _ = struct.unpack("<fhh", bytes.fromhex(only[4:]))
        speeds.append(steps / 1000)
    assert speeds[:3] == pytest.approx([0.78, 0.76, 0.74])
    assert speeds[-6:] == pytest.approx([0.0] * 6)
    assert position == pytest.approx(0.08 + 0.5 * 0.8**2 / 4.0, rel=1e-3)


def test_closing_finishes_the_ramp_and_then_takes_the_torque_away():
    bench = Bench()
    bench.start()
    bench.cycle(lambda: bench.driver.command_positions((0.004,)))
    bench.driver.close()
    frames = bench.sent()
    assert frames[-1] == "067#0100000000000000"
    assert struct.unpack_from("<fh", bytes.fromhex(frames[-2][4:]))[1] == 0
    assert len(frames) > 30
    bench.driver.close()
    assert bench.sent() == []


# The bus ---------------------------------------------------------------------------------


def test_on_a_raw_socket_remote_frames_and_setpoints_go_out_as_struct_can_frame():
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    clock = TestClock()
    bus = OdriveBus(
        "can0", OdriveBusSettings("x", "y"), lambda: SocketCanBus(ours, "can0"), clock, PERIOD
    )
    heard = []
    bus.subscribe(0x061, lambda data, now: heard.append((data, now)))
    setpoint = CyclicFrame(0x06C, bytes(8))
    bus.add(setpoint)
    bus.open()
    bus.request(0x060)
    bus.transmit(clock.now())
    setpoint.active = True
    bus.transmit(clock.now())
    packets = [theirs.recv(64) for _ in range(2)]
    assert packets[0] == struct.pack("=IB3x8s", 0x4000_0060, 0, b"")
    assert packets[1] == struct.pack("=IB3x8s", 0x06C, 8, bytes(8))
    theirs.send(struct.pack("=IB3x8s", 0x061, 7, b"\x01" * 7))
    theirs.send(struct.pack("=IB3x8s", 0x4000_0061, 0, b""))
    theirs.send(struct.pack("=IB3x8s", 0x07E, 1, b"\x01"))
    bus.receive(5.0)
    assert heard == [(b"\x01" * 7, 5.0)]
    counters = bus.statistics()
    assert (counters["remote"], counters["unknown"], counters["frames_in"]) == (1, 1, 3)
    bus.close()
    theirs.close()


def test_an_identifier_belongs_to_one_axis_and_a_closed_bus_refuses():
    bus = OdriveBus("can0", OdriveBusSettings("x", "y"), ScriptedBus, TestClock(), PERIOD)
    bus.subscribe(0x061, lambda data, now: None)
    with pytest.raises(ValueError, match=r"0x061 is used twice.*axis 3"):
        bus.subscribe(0x061, lambda data, now: None)
    with pytest.raises(OSError, match="not open"):
        bus.send(0x067, b"")
    bus.make_safe()
    bus.close()
