"""CANSimple, the CAN protocol of ODrive: bytes ↔ numbers, errors in words.

References
----------
ODrive Robotics, "CAN Protocol" (CANSimple) of firmware 0.6: identifier ``node << 5 | command``,
little-endian, float32; error flags of the API reference, ``ODrive.Error``.
"""

import struct
from enum import IntEnum
from typing import Final, NamedTuple

BROADCAST: Final = 0x3F
"""The node number of all axes."""


class Command(IntEnum):
    """Lower five bits of an identifier."""

    GET_VERSION = 0x00
    HEARTBEAT = 0x01
    GET_ERROR = 0x03
    RX_SDO = 0x04
    TX_SDO = 0x05
    ADDRESS = 0x06
    SET_AXIS_STATE = 0x07
    GET_ENCODER_ESTIMATES = 0x09
    SET_CONTROLLER_MODE = 0x0B
    SET_INPUT_POS = 0x0C
    SET_INPUT_VEL = 0x0D
    SET_LIMITS = 0x0F
    CLEAR_ERRORS = 0x18


class AxisState(IntEnum):
    """States of an axis that this driver asks for or meets."""

    UNDEFINED = 0
    IDLE = 1
    STARTUP_SEQUENCE = 2
    FULL_CALIBRATION_SEQUENCE = 3
    MOTOR_CALIBRATION = 4
    ENCODER_INDEX_SEARCH = 6
    ENCODER_OFFSET_CALIBRATION = 7
    CLOSED_LOOP_CONTROL = 8
    LOCKIN_SPIN = 9
    ENCODER_DIR_FIND = 10
    HOMING = 11
    ENCODER_HALL_POLARITY_CALIBRATION = 12
    ENCODER_HALL_PHASE_CALIBRATION = 13
    ANTICOGGING_CALIBRATION = 14


class ControlMode(IntEnum):
    """The kind of the host's innermost setpoint."""

    VELOCITY = 2
    POSITION = 3


PASSTHROUGH: Final = 1
"""Input mode: setpoints act as they come."""

WATCHDOG_TIMER_EXPIRED: Final = 0x0100_0000

_ERRORS: Final[dict[int, str]] = {
    0x0000_0001: "initialising",
    0x0000_0002: "system level error, firmware or hardware is broken",
    0x0000_0004: "timing error inside the firmware",
    0x0000_0008: "estimate of position or velocity is missing",
    0x0000_0010: "configuration is bad",
    0x0000_0020: "gate driver failed",
    0x0000_0040: "an input that is needed is missing",
    0x0000_0100: "over-voltage of the DC bus",
    0x0000_0200: "under-voltage of the DC bus",
    0x0000_0400: "over-current on the DC bus",
    0x0000_0800: "regeneration over-current on the DC bus",
    0x0000_1000: "motor current above its limit",
    0x0000_2000: "motor too hot",
    0x0000_4000: "inverter too hot",
    0x0000_8000: "speed above its limit",
    0x0001_0000: "position outside its limits",
    0x0100_0000: "watchdog expired, setpoints did not come in time",
    0x0200_0000: "emergency stop was requested",
    0x0400_0000: "spinout, the encoder slipped or is misaligned",
    0x0800_0000: "brake resistor is disarmed",
    0x1000_0000: "thermistor is disconnected",
    0x4000_0000: "calibration failed",
}

_HEARTBEAT: Final = struct.Struct("<IBBB")
_ERROR: Final = struct.Struct("<II")
_TWO_FLOATS: Final = struct.Struct("<ff")
_POSITION: Final = struct.Struct("<fhh")
_TWO_WORDS: Final = struct.Struct("<II")
_SDO: Final = struct.Struct("<BHB")

FEEDFORWARD_RANGE: Final = 0x7FFF
_READ, _WRITE = 0, 1


class Heartbeat(NamedTuple):
    """The state that an axis reports.

    Attributes
    ----------
    errors : int
        Flags; 0 if all is well.
    state : int
        `AxisState`, or one that this driver does not know.
    result : int
        Of the last procedure.
    done : int
        Bit 0: the trajectory is done.
    """

    errors: int
    state: int
    result: int
    done: int


class Version(NamedTuple):
    """The answer to Get_Version."""

    protocol: int
    hardware: tuple[int, int, int]
    firmware: tuple[int, int, int]
    unreleased: int


def can_id(node: int, command: Command) -> int:
    """Return the identifier of a command to or from a node."""
    return node << 5 | command


def decode_heartbeat(data: bytes) -> Heartbeat:
    """Decode a heartbeat of firmware 0.6, at least 7 bytes."""
    return Heartbeat(*_HEARTBEAT.unpack_from(data))


def decode_version(data: bytes) -> Version:
    """Decode the 8 bytes of Get_Version."""
    return Version(data[0], (data[1], data[2], data[3]), (data[4], data[5], data[6]), data[7])


def decode_address(data: bytes) -> tuple[int, int]:
    """Return node number and serial number of an Address message, at least 7 bytes."""
    return data[0], int.from_bytes(data[1:7], "little")


def decode_error(data: bytes) -> tuple[int, int]:
    """Return the active errors and the reason of the last disarming."""
    active, reason = _ERROR.unpack(data)
    return active, reason


decode_estimates = _TWO_FLOATS.unpack
"""Decode encoder estimates: position (turn) and velocity (turn/s) from 8 bytes."""


def encode_axis_state(state: AxisState) -> bytes:
    """Encode Set_Axis_State; 8 bytes, which every firmware 0.6 takes."""
    return _TWO_WORDS.pack(state, 0)


def encode_controller_mode(control: ControlMode, input_mode: int) -> bytes:
    """Encode Set_Controller_Mode."""
    return _TWO_WORDS.pack(control, input_mode)


def encode_input_position(position: float, velocity_steps: int, torque_steps: int = 0) -> bytes:
    """Encode Set_Input_Pos: turns, and feedforwards in steps."""
    return _POSITION.pack(position, velocity_steps, torque_steps)


encode_input_velocity = _TWO_FLOATS.pack
"""Encode Set_Input_Vel: velocity (turn/s) and torque feedforward (N m)."""

encode_limits = _TWO_FLOATS.pack
"""Encode Set_Limits: velocity (turn/s) and current (A)."""


def encode_sdo_read(endpoint: int) -> bytes:
    """Encode RxSdo that asks for a parameter."""
    return _SDO.pack(_READ, endpoint, 0) + bytes(4)


def encode_sdo_write(endpoint: int, value: bytes) -> bytes:
    """Encode RxSdo that sets a parameter to 1 … 4 bytes."""
    return _SDO.pack(_WRITE, endpoint, 0) + value.ljust(4, b"\0")


def decode_sdo(data: bytes) -> tuple[int, bytes]:
    """Return endpoint and value of a TxSdo: 4 bytes, as many as its type has, or none."""
    return int.from_bytes(data[1:3], "little"), bytes(data[4:8])


def describe_errors(errors: int) -> str:
    """Return error flags in words."""
    words = [
        _ERRORS.get(1 << bit, f"flag 0x{1 << bit:08X}") for bit in range(32) if errors >> bit & 1
    ]
    return ", ".join(words) or "no error"


def describe_axis_state(state: int) -> str:
    """Return the name of an axis state."""
    try:
        return AxisState(state).name.replace("_", " ")
    except ValueError:
        return f"unknown state {state}"
