"""CANSimple byte by byte: golden frames, and the DBC of `odrive-can` both ways."""

import struct

import pytest

from drivers.odrive.codec import (
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
