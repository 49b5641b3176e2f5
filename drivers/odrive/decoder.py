"""CANSimple frames in words: whose they are, what is in them, in SI.

References
----------
ODrive Robotics, "CAN Protocol" (CANSimple) of firmware 0.6.
"""

import struct
from collections.abc import Callable, Iterable
from math import tau
from pathlib import Path
from typing import Final, NamedTuple

from drivers.can.frame import REMOTE_FLAG, STANDARD_MASK, decode_error_frame
from drivers.odrive.codec import (
    BROADCAST,
    decode_address,
    decode_error,
    decode_heartbeat,
    decode_sdo,
    decode_version,
    describe_axis_state,
    describe_errors,
)
from drivers.odrive.settings import OdriveAxisSettings, OdriveBusSettings, OdriveSettings
from rig.hal import DriverSettings
from rig.hal.frames import UNKNOWN, Decoded, Value

_NAMES: Final = {
    0x00: "Get_Version",
    0x01: "Heartbeat",
    0x02: "Estop",
    0x03: "Get_Error",
    0x04: "RxSdo",
    0x05: "TxSdo",
    0x06: "Address",
    0x07: "Set_Axis_State",
    0x09: "Get_Encoder_Estimates",
    0x0B: "Set_Controller_Mode",
    0x0C: "Set_Input_Pos",
    0x0D: "Set_Input_Vel",
    0x0E: "Set_Input_Torque",
    0x0F: "Set_Limits",
    0x11: "Set_Traj_Vel_Limit",
    0x12: "Set_Traj_Accel_Limits",
    0x13: "Set_Traj_Inertia",
    0x14: "Get_Iq",
    0x15: "Get_Temperature",
    0x16: "Reboot",
    0x17: "Get_Bus_Voltage_Current",
    0x18: "Clear_Errors",
    0x19: "Set_Absolute_Position",
    0x1A: "Set_Pos_Gain",
    0x1B: "Set_Vel_Gains",
    0x1C: "Get_Torques",
    0x1D: "Get_Powers",
    0x1F: "Enter_DFU_Mode",
}
_CONTROL: Final = {0: "voltage", 1: "torque", 2: "velocity", 3: "position"}
_INPUT: Final = {1: "passthrough", 2: "velocity ramp", 3: "filtered position", 5: "trapezoid"}


class _Axis(NamedTuple):
    """One axis of the profile: its name and its joint's scales."""

    name: str
    joint: OdriveAxisSettings
    feedforward_scale: float

    def angle(self, turns: float) -> float:
        return turns / self.joint.turns_per_radian + self.joint.offset

    def rate(self, turns: float) -> float:
        return turns / self.joint.turns_per_radian


def make_decoder(
    bus: OdriveBusSettings, devices: Iterable[tuple[str, DriverSettings, Path | None]]
) -> "CansimpleDecoder":
    """Make the decoder of a bus.

    Parameters
    ----------
    bus : OdriveBusSettings
        Of the bus.
    devices : iterable of (str, DriverSettings, Path or None)
        Name and settings of each device on it. What is no ODrive to us shows as axes without a
        name.
    """
    return CansimpleDecoder(
        (name, settings) for name, settings, _ in devices if isinstance(settings, OdriveSettings)
    )


class CansimpleDecoder:
    """Decodes the frames of one bus.

    Parameters
    ----------
    devices : iterable of (str, OdriveSettings)
        Name and settings of each device on it.
    """

    def __init__(self, devices: Iterable[tuple[str, OdriveSettings]]) -> None:
        self._axes = {
            joint.axis: _Axis(f"{name} {called}", joint, settings.feedforward_scale)
            for name, settings in devices
            for called, joint in settings.joints.items()
        }

    def decode(self, can_id: int, data: bytes) -> Decoded:
        """Return what a frame says; see `rig.hal.frames.Decoder`."""
        error = decode_error_frame(can_id, data)
        if error is not None:
            return error
        asked = bool(can_id & REMOTE_FLAG)
        can_id &= ~REMOTE_FLAG
        if can_id > STANDARD_MASK:
            return UNKNOWN
        number, command = can_id >> 5, can_id & 0x1F
        service = _NAMES.get(command)
        if service is None:
            return UNKNOWN
        axis = self._axes.get(number)
        device = axis.name if axis is not None else f"axis {number}"
        known = axis is not None
        if number == BROADCAST:
            device, known = "all axes", True
        if asked:
            return Decoded(device, service, text="asked for", known=known)
        decode = _DECODERS.get(command)
        if decode is None or axis is None:
            return Decoded(device, service, known=known)
        try:
            return Decoded(device, service, tuple(decode(axis, data)))
        except (struct.error, IndexError):
            return Decoded(device, service, text=f"wrong length, {len(data)} bytes")


def _estimates(axis: _Axis, data: bytes) -> list[Value]:
    turns, speed = struct.unpack_from("<ff", data)
    return [
        Value("position", axis.angle(turns), "rad", "pos"),
        Value("velocity", axis.rate(speed), "rad/s", "vel"),
    ]


def _heartbeat(axis: _Axis, data: bytes) -> list[Value]:
    beat = decode_heartbeat(data)
    return [
        Value("state", describe_axis_state(beat.state), "", "axis_state"),
        Value("errors", describe_errors(beat.errors), "", "axis_error"),
    ]


def _errors(axis: _Axis, data: bytes) -> list[Value]:
    active, reason = decode_error(data[:8])
    return [
        Value("errors", describe_errors(active), "", "active_errors"),
        Value("disarmed for", describe_errors(reason), "", "disarm_reason"),
    ]


def _input_position(axis: _Axis, data: bytes) -> list[Value]:
    turns, velocity, torque = struct.unpack_from("<fhh", data)
    return [
        Value("target position", axis.angle(turns), "rad", "input_pos"),
        Value("feedforward", axis.rate(velocity / axis.feedforward_scale), "rad/s", "vel_ff"),
        Value("torque feedforward", torque, "", "torque_ff"),
    ]


def _input_velocity(axis: _Axis, data: bytes) -> list[Value]:
    speed, torque = struct.unpack_from("<ff", data)
    return [
        Value("target velocity", axis.rate(speed), "rad/s", "input_vel"),
        Value("torque feedforward", torque * axis.joint.gear, "N m", "torque_ff"),
    ]


def _limits(axis: _Axis, data: bytes) -> list[Value]:
    speed, current = struct.unpack_from("<ff", data)
    return [
        Value("speed limit", speed * tau / axis.joint.gear, "rad/s", "velocity_limit"),
        Value("current limit", current, "A", "current_limit"),
    ]


def _state(axis: _Axis, data: bytes) -> list[Value]:
    (state,) = struct.unpack_from("<I", data)
    return [Value("state", describe_axis_state(state), "", "axis_state")]


def _mode(axis: _Axis, data: bytes) -> list[Value]:
    control, given = struct.unpack_from("<II", data)
    return [
        Value("control", _CONTROL.get(control, str(control)), "", "control_mode"),
        Value("input", _INPUT.get(given, str(given)), "", "input_mode"),
    ]


def _version(axis: _Axis, data: bytes) -> list[Value]:
    version = decode_version(data)
    return [
        Value("hardware", ".".join(map(str, version.hardware)), "", "hw"),
        Value("firmware", ".".join(map(str, version.firmware)), "", "fw"),
    ]


def _address(axis: _Axis, data: bytes) -> list[Value]:
    node, serial = decode_address(data)
    return [Value("axis", node, "", "node_id"), Value("serial", f"{serial:012X}", "", "serial")]


def _parameter(axis: _Axis, data: bytes) -> list[Value]:
    endpoint, value = decode_sdo(data)
    content = f"0x{value.hex().upper()}" if value else "-"  # a question, or a confirmation
    return [Value(f"endpoint {endpoint}", content, "", "value")]


def _supply(axis: _Axis, data: bytes) -> list[Value]:
    voltage, current = struct.unpack_from("<ff", data)
    return [Value("voltage", voltage, "V", "bus"), Value("current", current, "A", "bus")]


_DECODERS: Final[dict[int, Callable[[_Axis, bytes], list[Value]]]] = {
    0x00: _version,
    0x01: _heartbeat,
    0x03: _errors,
    0x04: _parameter,
    0x05: _parameter,
    0x06: _address,
    0x07: _state,
    0x09: _estimates,
    0x0B: _mode,
    0x0C: _input_position,
    0x0D: _input_velocity,
    0x0F: _limits,
    0x17: _supply,
}
