"""What a CiA 402 drive is told, and asked, at each start.

References
----------
IEC 61800-7-201 (CiA 402-2): option codes 0x605A … 0x605E and 0x6007, following error 0x6065
and 0x6066, greatest torque 0x6072 and motor speed 0x6080, limits 0x607D, ramps 0x6084 and 0x6085,
interpolation period 0x60C2, units 0x608F, 0x6091 and 0x6092, offsets 0x60B0 … 0x60B2.
"""

from math import ceil
from typing import Final

from drivers.canopen.mapping import RANGES
from drivers.canopen.node import CanopenNode
from drivers.cia402.errors import describe_error
from drivers.cia402.settings import Cia402Settings, DriveSettings, Mode
from drivers.cia402.states import (
    DISABLE_VOLTAGE,
    FAULT_RESET,
    FAULTY,
    decode_state,
    describe_status,
)
from rig.hal import ConnectionFailed

MODES: Final[dict[Mode, int]] = {"csp": 8, "csv": 9}
"""Values of 0x6060; bit n - 1 of 0x6502 says that mode n is supported."""

_QUICK_STOP_RAMP_THEN: Final = {"release": 2, "hold": 6}  # 0x605A
_RAMP: Final = 1  # 0x605B, 0x605C, 0x605D: slow down by 0x6084 first
_QUICK_STOP_RAMP: Final = 2  # 0x605E
_QUICK_STOP: Final = 3  # 0x6007; 0 would carry on when the master has gone
_FREQUENCY_CONVERTER: Final = 1  # lower byte of the device type's upper word
_SCALE_TOLERANCE: Final = 1e-6
_EXPONENTS: Final = (-3, -4, -5, -6)

Setting = tuple[int, int, str, int]


def encode_interpolation_period(period: float) -> tuple[int, int]:
    """Return 0x60C2:1 and :2 for a period: ``value · 10^exponent`` seconds.

    Milliseconds where they will do, since some drives know nothing else.

    Raises
    ------
    ValueError
        No such pair stands for the period.
    """
    for exponent in _EXPONENTS:
        value = period * 10**-exponent
        if 1 <= round(value) <= 255 and abs(value - round(value)) < 1e-6 * value:
            return round(value), exponent
    raise ValueError(
        f"a drive cannot be told a period of {period * 1e3:g} ms: 0x60C2 holds 1 … 255 steps "
        "of 1, 0.1, 0.01 or 0.001 ms; choose another rate."
    )


def settings_to_write(
    drive: DriveSettings, shared: Cia402Settings, period: float
) -> tuple[Setting, ...]:
    """Return what is written and read back: index, sub-index, type and raw value.

    Parameters
    ----------
    drive : DriveSettings
        Of the joint.
    shared : Cia402Settings
        Of all joints.
    period : float
        Of the cycle, s.
    """
    steps, exponent = encode_interpolation_period(period)
    low, high = sorted(
        round((angle - drive.offset) * drive.counts_per_radian) for angle in drive.limits
    )
    ramp = _clamp(drive.deceleration * drive.acceleration_per_radian, "u32")
    window = _clamp(drive.following_window * abs(drive.counts_per_radian), "u32")
    settings: tuple[Setting, ...] = (
        (0x605A, 0, "i16", _QUICK_STOP_RAMP_THEN[shared.after_stop]),
        (0x605B, 0, "i16", _RAMP),
        (0x605C, 0, "i16", _RAMP),
        (0x605D, 0, "i16", _RAMP),
        (0x605E, 0, "i16", _QUICK_STOP_RAMP),
        (0x6007, 0, "i16", _QUICK_STOP),
        (0x6065, 0, "u32", window),
        (0x6066, 0, "u16", _clamp(drive.following_time * 1e3, "u16")),
        (0x6080, 0, "u32", _motor_speed(drive)),
        (0x607D, 1, "i32", low),
        (0x607D, 2, "i32", high),
        (0x6084, 0, "u32", ramp),
        (0x6085, 0, "u32", ramp),
        (0x60C2, 1, "u8", steps),
        (0x60C2, 2, "i8", exponent),
        (0x6060, 0, "i8", MODES[shared.mode]),
    )
    return tuple(setting for setting in settings if setting[0] not in shared.absent)


def check_kind(node: CanopenNode, kind: int, mode: Mode) -> None:
    """Refuse what is no servo drive, or does not know the mode.

    Raises
    ------
    ConnectionFailed
        It is a frequency converter, or 0x6502 lacks the mode.
    """
    if kind & 0xFF == _FREQUENCY_CONVERTER:
        raise _refused(node, "it is a frequency converter", "0x1000:00", f"type {kind}", "a servo")
    supported = node.read_if_present(0x6502, 0, "u32")
    if supported is not None and not int(supported) >> MODES[mode] - 1 & 1:
        raise _refused(
            node,
            f"it does not know the mode {mode}",
            "0x6502:00",
            f"0x{int(supported):08X}",
            f"bit {MODES[mode] - 1}",
        )


def check_scale(node: CanopenNode, drive: DriveSettings) -> None:
    """Compare the profile's counts per turn with the drive's own units.

    ``user units per turn = feed constant`` (0x6092), and without one the encoder's increments
    times the gear inside the drive (0x608F, 0x6091). A drive that says neither is believed.

    Raises
    ------
    ConnectionFailed
        They differ: every angle would be wrong.
    """
    found, thing = _ratio(node, 0x6092), "0x6092"
    if found is None:
        found, thing = _ratio(node, 0x608F), "0x608F"
        if found is not None:
            found *= _ratio(node, 0x6091) or 1.0
    if found is None:
        return
    if abs(found - drive.counts_per_turn) > _SCALE_TOLERANCE * drive.counts_per_turn:
        raise _refused(
            node,
            "its position unit is not the profile's",
            thing,
            f"{found:.9g} counts per turn",
            f"{drive.counts_per_turn:.9g} counts per turn",
        )


def configure(
    node: CanopenNode, joint: str, drive: DriveSettings, shared: Cia402Settings, period: float
) -> None:
    """Write every setting that matters for safety and motion, read it back, map the PDOs.

    Raises
    ------
    ConnectionFailed
        The drive did not take one.
    """
    for index, sub, kind, value in settings_to_write(drive, shared, period):
        node.write(index, sub, kind, value)
    if drive.max_torque is not None:
        _limit_torque(node, drive, drive.max_torque)
    # What another program left here would be added to every target.
    for index, kind in ((0x60B0, "i32"), (0x60B1, "i32"), (0x60B2, "i16")):
        if node.read_if_present(index, 0, kind):
            node.write(index, 0, kind, 0)
    if node.read_if_present(0x1029, 1, "u8") is not None:
        node.write(0x1029, 1, "u8", 0)  # without the master: PRE-OPERATIONAL, and 0x6007
    node.map_pdos((shared.receive_layout,), shared.transmit_layouts(joint), remap=shared.remap)


def prepare_velocity_stop(node: CanopenNode, shared: Cia402Settings) -> bool:
    """Have a drive in csp stand still when it is switched to csv; return whether it can be.

    Raises
    ------
    ConnectionFailed
        The drive did not take a target velocity of 0.
    """
    supported = int(node.read_if_present(0x6502, 0, "u32") or 0)
    left = node.read_if_present(0x60FF, 0, "i32")
    if shared.mode == "csv" or left is None or not supported >> MODES["csv"] - 1 & 1:
        return False
    if left:
        node.write(0x60FF, 0, "i32", 0)
    return True


def read_torque_unit(node: CanopenNode, drive: DriveSettings) -> float:
    """Return the joint's torque for one count of 0x6077, N m; 0 if the drive does not say."""
    rated = node.read_if_present(0x6076, 0, "u32")  # mN m
    sign = -1.0 if drive.reversed else 1.0
    return sign * drive.gear * 1e-6 * float(rated or 0)


def _motor_speed(drive: DriveSettings) -> int:
    """Return the motor's greatest speed as 0x6080 has it, whole turns per minute."""
    return _clamp(ceil(60.0 * drive.speed_cap * abs(drive.turns_per_radian)), "u32")


def _limit_torque(node: CanopenNode, drive: DriveSettings, torque: float) -> None:
    unit = abs(read_torque_unit(node, drive))
    if not unit:
        raise _refused(
            node,
            "it does not say its rated torque, of which its limit is a share; leave max_torque out",
            "0x6076:00",
            "none",
            f"max_torque {torque:g} N m",
        )
    node.write(0x6072, 0, "u16", _clamp(torque / unit, "u16"))


def refuse_fault(node: CanopenNode, error: ConnectionFailed) -> ConnectionFailed:
    """Return the refusal, in words, of a drive that reports an error while it is connected.

    Parameters
    ----------
    node : CanopenNode
        Of the drive; it answers.
    error : ConnectionFailed
        What was found: its error register is not 0.
    """
    code = int(node.read_if_present(0x603F, 0, "u16") or 0)
    status = int(node.read(0x6041, 0, "u16"))
    words = f"{describe_error(code)} (error code 0x{code:04X})" if code else error.what
    return node.failed(
        f"it reports a fault before it is used: {words}, {describe_status(status)}; "
        "remove the cause and reset the drive",
        object=error.object,
        value=error.value,
    )


def reset_fault(node: CanopenNode) -> None:
    """Give the rising edge of the control word that ends a fault whose cause has gone.

    Raises
    ------
    ConnectionFailed
        The drive stays in its fault.
    """
    for control in (DISABLE_VOLTAGE, FAULT_RESET, DISABLE_VOLTAGE):
        node.write(0x6040, 0, "u16", control, mask=0)
    status = int(node.read(0x6041, 0, "u16"))
    if decode_state(status) in FAULTY:
        code = int(node.read_if_present(0x603F, 0, "u16") or 0)
        raise node.failed(
            f"it stays in its fault: {describe_error(code)} (error code 0x{code:04X}), "
            f"{describe_status(status)}",
            object="0x6041:00",
        )
    node.emergency.clear()


def _ratio(node: CanopenNode, index: int) -> float | None:
    numerator = node.read_if_present(index, 1, "u32")
    denominator = node.read_if_present(index, 2, "u32")
    return numerator / denominator if numerator and denominator else None


def _clamp(value: float, kind: str) -> int:
    """Return a whole number of at least 1: zero would switch the limit off."""
    return int(min(max(round(value), 1), RANGES[kind][1]))


def _refused(node: CanopenNode, what: str, thing: str, value: str, bound: str) -> ConnectionFailed:
    return node.failed(what, object=thing, value=value, bound=bound)
