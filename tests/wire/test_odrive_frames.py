"""CANSimple byte by byte: golden frames, the DBC of `odrive-can`, and what may be wrong."""

import socket
import struct

import pytest
from scripted_bus import ScriptedBus, TestClock

from drivers.can.cyclic import CyclicFrame
from drivers.can.socketcan import SocketCanBus
from drivers.servos.odrive import OdriveServos
from drivers.servos.odrive_bus import OdriveBus
from drivers.servos.odrive_codec import (
    AxisState,
    Command,
    ControlMode,
    can_id,
    decode_address,
    decode_error,
    decode_estimates,
    decode_heartbeat,
    decode_sdo,
    decode_version,
    describe_axis_state,
    describe_errors,
    encode_axis_state,
    encode_controller_mode,
    encode_input_position,
    encode_input_velocity,
    encode_limits,
    encode_sdo_read,
    encode_sdo_write,
)
from drivers.servos.odrive_settings import (
    AxisSettings,
    OdriveBusSettings,
    OdriveEndpoints,
    OdriveSettings,
)
from rig.hal import ConnectionFailed, DeviceFault, LimitExceeded

PERIOD = 0.005
TAU = 6.283185307179586
REMOTE = 0x4000_0000


def frame(command, data, node=3):
    return f"{can_id(node, command):03X}#{data.hex().upper()}"


GOLDEN = [
    (Command.SET_AXIS_STATE, encode_axis_state(AxisState.CLOSED_LOOP_CONTROL),
     "067#0800000000000000"),
    (Command.SET_CONTROLLER_MODE, encode_controller_mode(ControlMode.POSITION, 1),
     "06B#0300000001000000"),
    (Command.SET_INPUT_POS, encode_input_position(1.5, 2000, -250), "06C#0000C03FD00706FF"),
    (Command.SET_LIMITS, encode_limits(10.0, 20.0), "06F#000020410000A041"),
    (Command.SET_INPUT_VEL, encode_input_velocity(-1.0, 0.5), "06D#000080BF0000003F"),
    (Command.RX_SDO, encode_sdo_read(0x1234), "064#0034120000000000"),
    (Command.RX_SDO, encode_sdo_write(0x0102, struct.pack("<f", 1.0)), "064#010201000000803F"),
    (Command.RX_SDO, encode_sdo_write(0x0102, b"\x01"), "064#0102010001000000"),
]  # fmt: skip


@pytest.mark.parametrize(("command", "data", "expected"), GOLDEN)
def test_golden_frames_of_the_master(command, data, expected):
    assert frame(command, data) == expected


def test_golden_heartbeat():
    heartbeat = decode_heartbeat(bytes.fromhex("0000000108000100"))
    assert heartbeat.errors == 0x01000000
    assert (heartbeat.state, heartbeat.result, heartbeat.done & 1) == (8, 0, 1)
    assert describe_errors(heartbeat.errors).startswith("watchdog expired")
    assert describe_axis_state(8) == "CLOSED LOOP CONTROL"
    assert describe_axis_state(99) == "unknown state 99"


def test_errors_in_words_are_those_of_the_enumeration_and_name_unknown_flags():
    enums = pytest.importorskip("odrive_can.enums")
    for error in enums.ODriveError:
        assert "flag" not in describe_errors(error.value), error
    assert describe_errors(0x80) == "flag 0x00000080"
    assert describe_errors(0x300).count("DC bus") == 2
    assert describe_errors(0) == "no error"
    for state in enums.AxisState:
        if state.name != "SENSORLESS_CONTROL":
            assert AxisState(state.value).name == state.name


# The DBC ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def dbc():
    pytest.importorskip("cantools")
    odrive_can = pytest.importorskip("odrive_can")
    return odrive_can.get_dbc("odrive-cansimple-0.6.10")


def test_what_we_encode_is_what_the_dbc_decodes(dbc):
    def decode(command, data):
        message = dbc.get_message_by_frame_id(can_id(3, command))
        return message.decode(data, decode_choices=False)

    assert decode(Command.SET_AXIS_STATE, encode_axis_state(AxisState.HOMING)) == {
        "Axis_Requested_State": 11
    }
    assert decode(Command.SET_CONTROLLER_MODE, encode_controller_mode(ControlMode.VELOCITY, 1)) == {
        "Control_Mode": 2,
        "Input_Mode": 1,
    }
    assert decode(Command.SET_INPUT_POS, encode_input_position(-2.25, -1500, 30)) == {
        "Input_Pos": -2.25,
        "Vel_FF": pytest.approx(-1.5),
        "Torque_FF": pytest.approx(0.03),
    }
    assert decode(Command.SET_INPUT_VEL, encode_input_velocity(3.5, -0.25)) == {
        "Input_Vel": 3.5,
        "Input_Torque_FF": -0.25,
    }
    assert decode(Command.SET_LIMITS, encode_limits(12.5, 30.0)) == {
        "Velocity_Limit": 12.5,
        "Current_Limit": 30.0,
    }


def test_what_the_dbc_encodes_is_what_we_decode(dbc):
    def encode(name, **signals):
        return dbc.get_message_by_name(f"Axis3_{name}").encode(signals, strict=False)

    assert decode_heartbeat(
        encode(
            "Heartbeat", Axis_Error=0x100, Axis_State=8, Procedure_Result=2, Trajectory_Done_Flag=1
        )
    ) == (0x100, 8, 2, 1)
    version = decode_version(
        encode(
            "Get_Version",
            Protocol_Version=2,
            Hw_Version_Major=4,
            Hw_Version_Minor=4,
            Hw_Version_Variant=58,
            Fw_Version_Major=0,
            Fw_Version_Minor=6,
            Fw_Version_Revision=11,
            Fw_Version_Unreleased=1,
        )
    )
    assert version == (2, (4, 4, 58), (0, 6, 11), 1)
    assert decode_address(encode("Address", Node_ID=5, Serial_Number=0x123456789ABC)) == (
        5,
        0x123456789ABC,
    )
    assert decode_error(encode("Get_Error", Active_Errors=1, Disarm_Reason=0x02000000)) == (
        1,
        0x02000000,
    )
    assert decode_estimates(
        encode("Get_Encoder_Estimates", Pos_Estimate=1.25, Vel_Estimate=-0.5)
    ) == (1.25, -0.5)
    assert decode_sdo(bytes.fromhex("0034120000004842")) == (0x1234, bytes.fromhex("00004842"))


def test_identifiers_are_those_of_the_dbc(dbc):
    names = {
        Command.GET_VERSION: "Get_Version",
        Command.HEARTBEAT: "Heartbeat",
        Command.GET_ERROR: "Get_Error",
        Command.ADDRESS: "Address",
        Command.SET_AXIS_STATE: "Set_Axis_State",
        Command.GET_ENCODER_ESTIMATES: "Get_Encoder_Estimates",
        Command.SET_CONTROLLER_MODE: "Set_Controller_Mode",
        Command.SET_INPUT_POS: "Set_Input_Pos",
        Command.SET_INPUT_VEL: "Set_Input_Vel",
        Command.SET_LIMITS: "Set_Limits",
        Command.CLEAR_ERRORS: "Clear_Errors",
        Command.RX_SDO: "RxSdo",
        Command.TX_SDO: "TxSdo",
    }
    for command, name in names.items():
        assert dbc.get_message_by_name(f"Axis5_{name}").frame_id == can_id(5, command)


# The driver on a scripted bus ------------------------------------------------------------

AXIS = {"axis": 3, "gear": TAU, "limits": (-1.0, 2.0), "max_speed": 1.0, "deceleration": 4.0}


class ScriptedOdrive:
    """An axis that answers remote frames, states and parameters, and sends estimates."""

    def __init__(self, bus):
        self.bus = bus
        self.state = 1
        self.errors = 0
        self.turns = 0.0
        self.version = (2, 4, 4, 58, 0, 6, 10, 0)
        self.serials = [0xABCDEF]
        self.endpoints = {7: struct.pack("<?", False), 8: bytes(4)}
        self.obeys = True
        self.beats = self.estimates = True
        bus.devices[3] = self

    def receive(self, can_id, data):
        command = can_id & 0x1F
        if can_id & REMOTE:
            if command == 0x06:
                for serial in self.serials:
                    self.bus.put(f"066#03{serial.to_bytes(6, 'little').hex()}00")
            elif command == 0x00 and self.version:
                self.bus.put(f"060#{bytes(self.version).hex()}")
            elif command == 0x03:
                self.bus.put(f"063#{struct.pack('<II', self.errors, self.errors).hex()}")
        elif command == 0x07 and self.obeys:
            self.state = data[0]
        elif command == 0x18 and self.obeys:
            self.errors = 0
        elif command == 0x04:
            number = int.from_bytes(data[1:3], "little")
            if data[0] == 1:
                size = len(self.endpoints[number])
                self.endpoints[number] = data[4 : 4 + size]
            else:
                value = self.endpoints[number].ljust(4, b"\0")
                self.bus.put(f"065#00{data[1:3].hex()}00{value.hex()}")

    def talk(self, speed=0.0):
        if self.beats:
            self.bus.put(f"061#{struct.pack('<IBBBB', self.errors, self.state, 0, 1, 0).hex()}")
        if self.estimates:
            self.bus.put(f"069#{struct.pack('<ff', self.turns, speed).hex()}")


class TalkingClock(TestClock):
    """Has the axis talk every 5 ms."""

    def __init__(self):
        super().__init__()
        self.axis = None
        self._next = self.time

    def sleep_until(self, t):
        while self.axis is not None and self._next <= t:
            self.axis.talk()
            self._next += PERIOD
        super().sleep_until(t)


class Bench:
    def __init__(self, axis=(), **settings):
        self.interface = ScriptedBus()
        self.clock = TalkingClock()
        self.axis = self.clock.axis = ScriptedOdrive(self.interface)
        can = OdriveBusSettings("scripted", "can0")
        self.bus = OdriveBus("can0", can, lambda: self.interface, self.clock, PERIOD)
        self.bus.open()
        joints = {"elbow": AxisSettings(**(AXIS | dict(axis)))}
        self.driver = OdriveServos("arm", OdriveSettings(joints=joints, **settings), self.bus)

    def sent(self):
        frames, self.interface.sent[:] = list(self.interface.sent), []
        return frames

    def connect(self):
        self.driver.connect()
        return self.sent()

    def cycle(self, command=None):
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        if command is not None:
            command()
        self.bus.transmit(now)
        self.clock.sleep_until(now + PERIOD)
        return self.sent()

    def start(self):
        self.connect()
        self.driver.arm()
        frames = []
        for _ in range(60):
            frames += self.cycle()
            if self.driver.is_enabled:
                return frames
        raise AssertionError("never enabled")


def test_the_start_sends_these_frames_in_this_order():
    assert Bench(axis={"current_limit": 20.0}).connect() == [
        "400007E6#",  # remote: addresses of all
        "40000060#",  # remote: version
        "40000063#",  # remote: errors
        "067#0100000000000000",  # idle
        "06B#0300000001000000",  # position, passthrough
        "06F#0000A03F0000A041",  # 1.25 turn/s, 20 A
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


def test_setpoints_feed_the_watchdog_before_the_loop_is_closed():
    bench = Bench()
    bench.axis.turns = 0.25
    frames = bench.start()
    hold = f"06C#{struct.pack('<fhh', 0.25, 0, 0).hex().upper()}"
    assert frames[:3] == ["067#0800000000000000", hold, hold]
    assert set(frames[1:]) == {hold}
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


# What may be wrong while it is connected -------------------------------------------------


def test_nobody_there():
    bench = Bench()
    bench.clock.axis = None
    with pytest.raises(ConnectionFailed, match=r"joint elbow \(node 0x03\).*no heartbeat"):
        bench.connect()


def test_old_firmware_is_refused_with_a_sentence():
    bench = Bench()
    bench.axis.version = (2, 3, 6, 56, 0, 5, 6, 0)
    with pytest.raises(ConnectionFailed, match=r"other things.*firmware 0\.5\.6.*0\.6 or later"):
        bench.connect()
    bench.axis.version = None
    with pytest.raises(ConnectionFailed, match=r"does not say its version.*update it"):
        bench.connect()


def test_serial_numbers_are_compared_and_doubles_found():
    Bench(axis={"serial": 0xABCDEF}).connect()
    with pytest.raises(ConnectionFailed, match=r"serial number.*000000ABCDEF.*000000000001"):
        Bench(axis={"serial": 1}).connect()
    bench = Bench()
    bench.axis.serials.append(0x77)
    with pytest.raises(ConnectionFailed, match="2 ODrives have this node number"):
        bench.connect()


def test_errors_before_use_are_refused_in_words_but_not_an_expired_watchdog():
    bench = Bench()
    bench.axis.errors = 0x4000000
    with pytest.raises(ConnectionFailed, match=r"reports an error.*spinout.*remove the cause"):
        bench.connect()
    bench.driver.reset_fault()
    bench.connect()
    bench = Bench()
    bench.axis.errors = 0x1000000
    frames = bench.start()
    assert "078#00" in frames, "a new run begins with clearing what ended the last one"


def test_errors_that_stay_are_named():
    bench = Bench()
    bench.axis.errors, bench.axis.obeys = 0x100, False
    bench.clock.sleep_until(bench.clock.now() + PERIOD)
    with pytest.raises(ConnectionFailed, match=r"errors stay: over-voltage of the DC bus"):
        bench.driver.reset_fault()


def test_a_parameter_that_is_not_kept_is_refused():
    bench = Bench(endpoints=OdriveEndpoints(enable_watchdog=7, watchdog_timeout=8))
    keep = bench.axis.receive

    def forget(can_id, data):
        if can_id != 0x064 or data[0] != 1:
            keep(can_id, data)

    bench.axis.receive = forget
    with pytest.raises(ConnectionFailed, match=r"reads back another.*endpoint 8 \(watchdog_tim"):
        bench.connect()


def test_estimates_that_come_too_seldom_are_refused():
    bench = Bench()
    talk = bench.axis.talk
    bench.axis.talk = lambda: talk() if round(bench.clock.time / PERIOD) % 4 == 0 else None
    with pytest.raises(ConnectionFailed, match=r"estimates come too seldom.*one in 0.005 s"):
        bench.connect()


def test_an_axis_that_does_not_go_idle_or_close_its_loop_is_named():
    bench = Bench(enable_time=0.2)
    bench.axis.obeys = False
    bench.axis.state = 8
    with pytest.raises(ConnectionFailed, match=r"CLOSED LOOP CONTROL.*bound IDLE"):
        bench.connect()
    bench.axis.state = 1
    with pytest.raises(DeviceFault, match=r"does not close its loop.*axis state 1 \(IDLE\)"):
        bench.start()


def test_a_joint_outside_its_limits_is_not_energised():
    bench = Bench()
    bench.axis.turns = 2.5
    with pytest.raises(ConnectionFailed, match=r"outside its limits.*2.5 rad.*-1 … 2 rad"):
        bench.start()


# What may be wrong while it runs ---------------------------------------------------------


@pytest.fixture
def arm():
    bench = Bench()
    bench.start()
    return bench


def test_an_error_is_named_in_words_with_joint_and_node(arm):
    arm.axis.errors, arm.axis.state = 0x01000000, 1
    with pytest.raises(DeviceFault) as caught:
        for _ in range(3):
            arm.cycle()
    for part in ("arm joint elbow (node 0x03)", "watchdog expired", "0x01000000", "IDLE"):
        assert part in str(caught.value)


def test_an_axis_that_opens_its_loop_by_itself(arm):
    arm.axis.state = 1
    with pytest.raises(DeviceFault, match=r"left its closed loop.*no error"):
        for _ in range(3):
            arm.cycle()


def test_a_jump_and_no_number_are_not_taken(arm):
    arm.axis.turns = 0.5
    with pytest.raises(DeviceFault, match=r"position jumped.*\+0.5 rad"):
        for _ in range(3):
            arm.cycle()
    assert arm.driver.positions().value == (0.0,)
    bench = Bench()
    bench.start()
    bench.axis.turns = float("nan")
    with pytest.raises(DeviceFault, match="position jumped"):
        for _ in range(3):
            bench.cycle()


@pytest.mark.parametrize(
    ("silent", "message"),
    [("beats", "heartbeat is lost"), ("estimates", "sends no encoder estimates any more")],
)
def test_silence_is_a_fault(arm, silent, message):
    setattr(arm.axis, silent, False)
    with pytest.raises(DeviceFault, match=message):
        for _ in range(60):
            arm.cycle()


def test_a_pause_of_the_loop_makes_no_old_reading_of_a_new_estimate(arm):
    """As when another device takes its time to be armed: the frames wait meanwhile."""
    arm.clock.sleep_until(arm.clock.now() + 0.5)
    arm.cycle()
    assert arm.clock.now() - arm.driver.positions().t <= 2.0 * PERIOD + 1e-9


def test_short_foreign_and_extended_frames_change_nothing(arm):
    arm.interface.put("069#0000003F", "061#00", "08D#0000803F00000000", "063#00")
    arm.interface.put("0FFFFFFE#0011", is_extended_id=True)
    arm.cycle()
    assert arm.driver.positions().value == (0.0,)
    assert arm.driver.statistics()["wrong_length"] == 3
    assert arm.bus.statistics()["unknown"] == 2


@pytest.mark.parametrize(
    ("command", "argument", "message"),
    [
        ("command_positions", (2.5,), "joint elbow: position setpoint is 2.5 rad"),
        ("command_positions", (0.006,), "position setpoint is 0.006 rad"),
        ("command_velocities", (float("nan"),), "velocity setpoint is nan"),
    ],
)
def test_setpoints_that_no_program_should_send_are_refused(arm, command, argument, message):
    with pytest.raises(LimitExceeded, match=message):
        getattr(arm.driver, command)(argument)


def test_a_refused_frame_and_a_lost_link_are_the_buss_faults(arm):
    arm.interface.refusing = OSError(100, "Network is down")
    arm.bus.transmit(arm.clock.now())
    with pytest.raises(DeviceFault, match=r"can0: the interface went down"):
        arm.bus.check(arm.clock.now())


# Settings --------------------------------------------------------------------------------


def axis(**changes):
    return AxisSettings(**(AXIS | changes))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: OdriveSettings(joints={"a": axis(), "b": axis()}), "joints a and b.*axis 3"),
        (
            lambda: OdriveSettings(joints={"a": axis(gear=100.0, max_speed=3.0)}),
            r"feedforward of 47\.\d+ turn/s does not fit",
        ),
        (lambda: axis(limits=(1.0, 0.0)), "no range of angles"),
    ],
)
def test_settings_that_cannot_be_right_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"watchdog": 0.01, "period": 0.01}, "watchdog.*two periods"),
        ({"encoder_period": 0.01}, "encoder_period.*longer than the cycle"),
        ({"period": None}, "no period"),
    ],
)
def test_a_cycle_that_does_not_fit_is_refused(changes, message):
    period = changes.pop("period", PERIOD)
    bus = OdriveBus("can0", OdriveBusSettings("x", "y"), ScriptedBus, TestClock(), period)
    with pytest.raises(ValueError, match=message):
        OdriveServos("arm", OdriveSettings(joints={"a": axis()}, **changes), bus)


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
