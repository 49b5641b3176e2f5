"""What the objects of the emulated nodes are called in their EDS files.

References
----------
CiA 301 V4.2, CiA 401 V3.0, CiA 406 V3.2 and IEC 61800-7-201 (CiA 402-2): names of objects.
"""

from typing import Final

Names = dict[int, str | tuple[str, ...]]
"""By index: a name, or the object's name and those of its sub-indices from 1 on.

A last name with ``{}`` goes on counting.
"""

COMMON: Final[Names] = {
    0x1000: "Device type",
    0x1001: "Error register",
    0x1003: ("Pre-defined error field", "Standard error field {}"),
    0x1005: "COB-ID SYNC message",
    0x1008: "Manufacturer device name",
    0x1014: "COB-ID emergency message",
    0x1015: "Inhibit time emergency",
    0x1016: ("Consumer heartbeat time", "Consumer heartbeat time {}"),
    0x1017: "Producer heartbeat time",
    0x1018: ("Identity object", "Vendor-ID", "Product code", "Revision number", "Serial number"),
    0x1029: ("Error behaviour", "Communication error"),
    0x1200: ("SDO server parameter", "COB-ID client to server", "COB-ID server to client"),
}

IO_MODULE: Final[Names] = {
    0x6000: ("Read input 8-bit", "DigitalInput {}"),
    0x6200: ("Write output 8-bit", "DigitalOutput {}"),
    0x6206: ("Error mode output 8-bit", "Error mode of byte {}"),
    0x6207: ("Error value output 8-bit", "Error value of byte {}"),
    0x6401: ("Read analogue input 16-bit", "AnalogueInput {}"),
    0x6411: ("Write analogue output 16-bit", "AnalogueOutput {}"),
    0x6421: ("Analogue input interrupt trigger selection", "Trigger of input {}"),
    0x6423: "Analogue input global interrupt enable",
    0x6424: ("Analogue input interrupt upper limit integer", "Upper limit of input {}"),
    0x6425: ("Analogue input interrupt lower limit integer", "Lower limit of input {}"),
    0x6426: ("Analogue input interrupt delta unsigned", "Delta of input {}"),
    0x6443: ("Analogue output error mode", "Error mode of output {}"),
    0x6444: ("Analogue output error value integer", "Error value of output {}"),
}

ENCODER: Final[Names] = {
    0x6000: "Operating parameters",
    0x6002: "Total measuring range",
    0x6003: "Preset value",
    0x6004: "Position value",
    0x6005: ("Measuring step settings", "Position step", "Speed step"),
    0x6030: ("Speed value", "Speed value channel {}"),
    0x6200: "Cyclic timer",
    0x6500: "Operating status",
    0x6501: "Measuring step",
    0x6503: "Alarms",
    0x6504: "Supported alarms",
    0x6505: "Warnings",
    0x6506: "Supported warnings",
    0x6507: "Profile and software version",
    0x6508: "Operating time",
    0x6509: "Offset value",
}

DRIVE: Final[Names] = {
    0x6007: "Abort connection option code",
    0x603F: "Error code",
    0x6040: "Controlword",
    0x6041: "Statusword",
    0x605A: "Quick stop option code",
    0x605B: "Shutdown option code",
    0x605C: "Disable operation option code",
    0x605D: "Halt option code",
    0x605E: "Fault reaction option code",
    0x6060: "Modes of operation",
    0x6061: "Modes of operation display",
    0x6062: "Position demand value",
    0x6064: "Position actual value",
    0x6065: "Following error window",
    0x6066: "Following error time out",
    0x606C: "Velocity actual value",
    0x6072: "Max torque",
    0x6076: "Motor rated torque",
    0x6077: "Torque actual value",
    0x607A: "Target position",
    0x607D: ("Software position limit", "Min position limit", "Max position limit"),
    0x6080: "Max motor speed",
    0x6084: "Profile deceleration",
    0x6085: "Quick stop deceleration",
    0x608F: ("Position encoder resolution", "Encoder increments", "Motor revolutions"),
    0x6091: ("Gear ratio", "Motor revolutions", "Shaft revolutions"),
    0x6092: ("Feed constant", "Feed", "Shaft revolutions"),
    0x60B0: "Position offset",
    0x60B1: "Velocity offset",
    0x60C2: ("Interpolation time period", "Period value", "Time index"),
    0x60F4: "Following error actual value",
    0x60FD: "Digital inputs",
    0x60FF: "Target velocity",
    0x6502: "Supported drive modes",
}

_COMMUNICATION: Final = {
    1: "COB-ID",
    2: "Transmission type",
    3: "Inhibit time",
    5: "Event timer",
}


def name_of(index: int, sub: int | None, names: Names) -> str:
    """Return the name of an object, or of one of its sub-indices.

    Parameters
    ----------
    index : int
        The object.
    sub : int or None
        None: of the object as a whole.
    names : Names
        Of the device profile; those of CiA 301 are known.

    Raises
    ------
    KeyError
        It has none: an object was added and not named.
    """
    if 0x1400 <= index < 0x1C00:
        return _pdo_name(index, sub)
    found = {**COMMON, **names}[index]
    whole, *parts = (found,) if isinstance(found, str) else found
    if sub is None or not parts:
        return whole
    if sub == 0:
        return "Highest sub-index supported"
    return parts[min(sub, len(parts)) - 1].format(sub)


def _pdo_name(index: int, sub: int | None) -> str:
    kind = "Receive" if index < 0x1800 else "Transmit"
    is_mapping = bool(index & 0x200)
    number = (index & 0x1FF) + 1
    if sub is None:
        return f"{kind} PDO {number} {'mapping' if is_mapping else 'communication'} parameter"
    if sub == 0:
        return "Number of mapped objects" if is_mapping else "Highest sub-index supported"
    return f"Mapping entry {sub}" if is_mapping else _COMMUNICATION[sub]
