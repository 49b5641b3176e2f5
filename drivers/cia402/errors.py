"""Error codes of drives, object 0x603F and the first word of their EMCY, in words.

References
----------
IEC 61800-7-201 (CiA 402-2), error codes.
"""

from typing import Final

from drivers.canopen.emergency import describe_code

_CODES: Final[dict[int, str]] = {
    0x2110: "short circuit or earth leakage at the input",
    0x2120: "earth leakage at the input",
    0x2130: "short circuit at the input",
    0x2211: "current inside the device too high",
    0x2214: "current inside the device too high",
    0x2220: "continuous over-current inside the device",
    0x2230: "short circuit or earth leakage inside the device",
    0x2310: "continuous over-current at the motor",
    0x2311: "over-current at the motor",
    0x2312: "over-current at the motor",
    0x2320: "short circuit or earth leakage at the motor",
    0x2330: "earth leakage at the motor",
    0x2340: "short circuit at the motor",
    0x2350: "thermal overload of the motor (I²t)",
    0x3110: "mains over-voltage",
    0x3120: "mains under-voltage",
    0x3130: "mains phase missing",
    0x3210: "over-voltage of the DC link",
    0x3220: "under-voltage of the DC link",
    0x3310: "over-voltage at the output",
    0x3321: "armature circuit interrupted",
    0x3331: "field circuit interrupted",
    0x4110: "ambient temperature too high",
    0x4210: "drive too hot",
    0x4220: "drive too cold",
    0x4310: "motor too hot",
    0x4320: "motor too cold",
    0x5112: "supply voltage of 24 V too low",
    0x5113: "supply voltage of 5 V too low",
    0x5440: "contactor failed",
    0x5530: "parameter memory failed",
    0x6010: "software reset by its watchdog",
    0x6320: "parameter error",
    0x7110: "braking chopper failed",
    0x7121: "motor blocked",
    0x7122: "motor error, or wrong commutation",
    0x7300: "sensor error",
    0x7305: "incremental encoder 1 failed",
    0x7306: "incremental encoder 2 failed",
    0x7310: "speed measurement failed",
    0x7320: "position measurement failed",
    0x7500: "communication of the drive failed",
    0x8311: "excess torque",
    0x8331: "torque fault",
    0x8400: "speed controller error",
    0x8500: "position controller error",
    0x8611: "following error too large",
    0x8612: "reference limit reached",
    0x8700: "SYNC error",
    0x9000: "external error",
}
_GROUPS: Final[dict[int, str]] = {
    0x71: "power electronics",
    0x72: "measurement circuit",
    0x73: "sensor",
    0x75: "communication",
    0x83: "torque control",
    0x84: "speed control",
    0x85: "position control",
    0x86: "positioning",
    0x87: "synchronisation",
}


def describe_error(code: int) -> str:
    """Return an error code in words: its own, else its group's."""
    return _CODES.get(code) or _GROUPS.get(code >> 8) or describe_code(code)
