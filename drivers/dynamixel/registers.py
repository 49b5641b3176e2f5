"""The control table of the X series: addresses, sizes, units, and what error bits mean.

References
----------
ROBOTIS e-Manual, control tables of XM430-W350, XL430-W250 and XL330-M288; the numbers of the
models as Ping reports them.
"""

import math
import struct
from typing import Final, Literal, NamedTuple

COUNTS_PER_TURN: Final = 4096
COUNT_AT_ZERO: Final = 2048
MULTI_TURN_REACH: Final = 1_048_575  # of 116 in the modes with many turns, counts
VELOCITY_STEP: Final = 0.229 * math.tau / 60.0  # of 44, 104, 112, 128: 0.229 rpm in rad/s
MAX_VELOCITY_LIMIT: Final = 1023  # of 44
ACCELERATION_STEP: Final = 214.577 * math.tau / 3600.0  # of 108: 214.577 rev/min² in rad/s²
VOLTAGE_STEP: Final = 0.1  # V
WATCHDOG_STEP: Final = 0.02  # s
WATCHDOG_MAX: Final = 127
CELSIUS: Final = 273.15  # K


class Register(NamedTuple):
    """One entry of the control table.

    Attributes
    ----------
    address : int
        Of its first byte.
    code : str
        Its `struct` code.
    name : str
        As the maker calls it.
    """

    address: int
    code: str
    name: str

    @property
    def size(self) -> int:
        """Return its bytes."""
        return struct.calcsize("<" + self.code)

    def encode(self, value: int) -> bytes:
        """Return a value's bytes."""
        return struct.pack("<" + self.code, value)

    def decode(self, data: bytes) -> int:
        """Return the value of bytes."""
        value: int = struct.unpack("<" + self.code, data)[0]
        return value

    def __str__(self) -> str:
        return f"{self.name} ({self.address})"


RETURN_DELAY: Final = Register(9, "B", "Return Delay Time")
DRIVE_MODE: Final = Register(10, "B", "Drive Mode")
OPERATING_MODE: Final = Register(11, "B", "Operating Mode")
HOMING_OFFSET: Final = Register(20, "i", "Homing Offset")
CURRENT_LIMIT: Final = Register(38, "H", "Current Limit")
VELOCITY_LIMIT: Final = Register(44, "I", "Velocity Limit")
MAX_POSITION: Final = Register(48, "I", "Max Position Limit")
MIN_POSITION: Final = Register(52, "I", "Min Position Limit")
TORQUE_ENABLE: Final = Register(64, "B", "Torque Enable")
STATUS_RETURN: Final = Register(68, "B", "Status Return Level")
HARDWARE_ERROR: Final = Register(70, "B", "Hardware Error Status")
VELOCITY_I: Final = Register(76, "H", "Velocity I Gain")
VELOCITY_P: Final = Register(78, "H", "Velocity P Gain")
POSITION_D: Final = Register(80, "H", "Position D Gain")
POSITION_I: Final = Register(82, "H", "Position I Gain")
POSITION_P: Final = Register(84, "H", "Position P Gain")
FEEDFORWARD_2: Final = Register(88, "H", "Feedforward 2nd Gain")
FEEDFORWARD_1: Final = Register(90, "H", "Feedforward 1st Gain")
BUS_WATCHDOG: Final = Register(98, "b", "Bus Watchdog")
GOAL_CURRENT: Final = Register(102, "h", "Goal Current")
GOAL_VELOCITY: Final = Register(104, "i", "Goal Velocity")
PROFILE_ACCELERATION: Final = Register(108, "I", "Profile Acceleration")
PROFILE_VELOCITY: Final = Register(112, "I", "Profile Velocity")
GOAL_POSITION: Final = Register(116, "i", "Goal Position")
PRESENT_CURRENT: Final = Register(126, "h", "Present Current")
PRESENT_VELOCITY: Final = Register(128, "i", "Present Velocity")
PRESENT_POSITION: Final = Register(132, "i", "Present Position")
INPUT_VOLTAGE: Final = Register(144, "H", "Present Input Voltage")
TEMPERATURE: Final = Register(146, "B", "Present Temperature")
INDIRECT_ADDRESS: Final = 168  # of the first; two bytes each

MOTION: Final = (PRESENT_CURRENT, PRESENT_VELOCITY, PRESENT_POSITION)
"""What a servo tells of its motion: 126 … 135, contiguous."""
HEALTH: Final = (HARDWARE_ERROR, BUS_WATCHDOG, INPUT_VOLTAGE, TEMPERATURE)
"""What a servo tells of itself; scattered, so read by indirect addresses."""

WATCHDOG_TRIPPED: Final = -1
STATUS_OF_ALL: Final = 2  # of 68: every instruction is answered

Mode = Literal["position", "extended_position", "current_based_position", "velocity"]
MODES: Final[dict[Mode, int]] = {
    "velocity": 1,
    "position": 3,
    "extended_position": 4,
    "current_based_position": 5,
}

_STATUS_ERRORS: Final = {
    1: "it failed to process the instruction",
    2: "it does not know the instruction",
    3: "the instruction's CRC was wrong when it arrived",
    4: "the value is out of the register's range, or its bus watchdog has tripped",
    5: "the data are shorter than the register",
    6: "the value is beyond one of its limits",
    7: "the register cannot be accessed so (read-only, not there, or locked by torque)",
}
_HARDWARE_ERRORS: Final = {
    0: "input voltage out of range",
    2: "overheated",
    3: "motor encoder broken",
    4: "electrical shock, or too little power for the motor",
    5: "overloaded for too long",
}
ALERT: Final = 0x80


class Model(NamedTuple):
    """The properties that differ from model to model.

    Attributes
    ----------
    number : int
        What Ping reports.
    current_step : float
        Of the current registers, A; 0 if the model measures its load in 0.1 % instead.
    indirect_data : int
        Address of the first byte of indirect data.
    torque_constant : float
        Stall torque over stall current at the nominal voltage, N m/A.
    """

    number: int
    current_step: float
    indirect_data: int
    torque_constant: float


ModelName = Literal[
    "xl330-m077",
    "xl330-m288",
    "xc330-m181",
    "xc330-m288",
    "xl430-w250",
    "xc430-w150",
    "xc430-w240",
    "xm430-w210",
    "xm430-w350",
    "xh430-w210",
    "xh430-w350",
    "xm540-w150",
    "xm540-w270",
    "xh540-w150",
    "xh540-w270",
]
MODELS: Final[dict[ModelName, Model]] = {
    "xl330-m077": Model(1190, 1e-3, 208, 0.215 / 1.47),
    "xl330-m288": Model(1200, 1e-3, 208, 0.52 / 1.47),
    "xc330-m181": Model(1230, 1e-3, 208, 0.6 / 1.8),
    "xc330-m288": Model(1240, 1e-3, 208, 0.93 / 1.8),
    "xl430-w250": Model(1060, 0.0, 224, 0.0),
    "xc430-w150": Model(1070, 0.0, 224, 0.0),
    "xc430-w240": Model(1080, 0.0, 224, 0.0),
    "xm430-w210": Model(1030, 2.69e-3, 224, 3 / 2.3),
    "xm430-w350": Model(1020, 2.69e-3, 224, 4.1 / 2.3),
    "xh430-w210": Model(1010, 2.69e-3, 224, 2.5 / 1.3),
    "xh430-w350": Model(1000, 2.69e-3, 224, 3.4 / 1.3),
    "xm540-w150": Model(1130, 2.69e-3, 224, 7.3 / 4.4),
    "xm540-w270": Model(1120, 2.69e-3, 224, 10.6 / 4.4),
    "xh540-w150": Model(1110, 2.69e-3, 224, 7.1 / 4.9),
    "xh540-w270": Model(1100, 2.69e-3, 224, 9.9 / 4.9),
}


def describe_status_error(error: int) -> str:
    """Return the error of a status packet in words; empty if there is none."""
    code = error & ~ALERT
    words = [_STATUS_ERRORS.get(code, f"error number {code}")] if code else []
    if error & ALERT:
        words.append("it has a hardware error")
    return "; ".join(words)


def describe_hardware_error(bits: int) -> str:
    """Return the bits of Hardware Error Status in words."""
    return ", ".join(_HARDWARE_ERRORS.get(bit, f"bit {bit}") for bit in range(8) if bits >> bit & 1)


def describe_model(number: int) -> str:
    """Return a model's name for its number."""
    for name, model in MODELS.items():
        if model.number == number:
            return name
    return f"model number {number}"
