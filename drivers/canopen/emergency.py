"""Emergency messages (EMCY) in words, and a latch for them.

References
----------
CiA 301 V4.2, section 7.2.7 and table 26 (error codes); CiA 401 V3.0 and CiA 406 V3.2 for
those of their profiles.
"""

from typing import Final, NamedTuple

_CODES: Final[dict[int, str]] = {
    0x2310: "current at the outputs too high",
    0x2320: "short circuit at the outputs",
    0x2330: "load dump at the outputs",
    0x3110: "mains voltage too high",
    0x3120: "mains voltage too low",
    0x3210: "internal voltage too high",
    0x3220: "internal voltage too low",
    0x3310: "output voltage too high",
    0x3320: "output voltage too low",
    0x8110: "CAN overrun, frames lost",
    0x8120: "CAN in error passive mode",
    0x8130: "the master's heartbeat or node guarding failed",
    0x8140: "recovered from bus-off",
    0x8150: "CAN identifier collision",
    0x8210: "PDO not processed: wrong length",
    0x8220: "PDO length exceeded",
    0x8230: "destination object of a multiplexed PDO not available",
    0x8240: "SYNC with unexpected length",
    0x8250: "RPDO did not come in time",
}
_NOT_TAKEN: Final = (0x8210, 0x8220, 0x8250)
_GROUPS: Final[dict[int, str]] = {
    0x10: "generic error",
    0x20: "current",
    0x21: "current at the device's input",
    0x22: "current inside the device",
    0x23: "current at the device's output",
    0x30: "voltage",
    0x31: "mains voltage",
    0x32: "voltage inside the device",
    0x33: "output voltage",
    0x40: "temperature",
    0x41: "ambient temperature",
    0x42: "device temperature",
    0x50: "device hardware",
    0x60: "device software",
    0x61: "internal software",
    0x62: "user software",
    0x63: "data set",
    0x70: "additional modules",
    0x80: "monitoring",
    0x81: "communication",
    0x82: "protocol error",
    0x90: "external error",
    0xF0: "additional functions",
    0xFF: "device specific",
}
_REGISTER: Final = (
    "generic",
    "current",
    "voltage",
    "temperature",
    "communication",
    "device profile",
    "reserved",
    "manufacturer",
)


class Emergency(NamedTuple):
    """A decoded EMCY.

    Attributes
    ----------
    code : int
        Error code; 0x00xx means that errors are gone.
    register : int
        The device's error register, object 0x1001.
    detail : bytes
        What the maker adds, up to 5 bytes.
    """

    code: int
    register: int
    detail: bytes

    @property
    def is_reset(self) -> bool:
        """Whether the device says that an error is gone."""
        return self.code < 0x0100

    @property
    def is_about_setpoints(self) -> bool:
        """Whether the device says that it did not take setpoints which were sent, or came late."""
        return self.code in _NOT_TAKEN

    def __str__(self) -> str:
        text = f"EMCY 0x{self.code:04X} ({describe_code(self.code)})"
        if self.register:
            text += f", error register 0x{self.register:02X} ({describe_register(self.register)})"
        if any(self.detail):
            text += f", maker's bytes {self.detail.hex(' ').upper()}"
        return text


def describe_code(code: int) -> str:
    """Return an error code in words: the code itself, else its group."""
    if code < 0x0100:
        return "error reset"
    return (
        _CODES.get(code)
        or _GROUPS.get(code >> 8)
        or _GROUPS.get(code >> 8 & 0xF0)
        or "unknown group"
    )


def describe_register(register: int) -> str:
    """Return the bits of the error register in words."""
    return ", ".join(word for bit, word in enumerate(_REGISTER) if register >> bit & 1)


def decode_emergency(data: bytes) -> Emergency:
    """Decode an EMCY; one that is too short is taken as far as it goes.

    An emergency must not be lost because a device leaves bytes out.
    """
    padded = bytes(data[:8]).ljust(8, b"\0")
    code = int.from_bytes(padded[:2], "little")
    if len(data) < 2:
        code = 0xFF00  # something was wrong enough to send it
    return Emergency(code, padded[2], padded[3:])


class EmergencyLatch:
    """Keep the first emergency of a node until it is cleared by an operator's reset.

    Attributes
    ----------
    active : Emergency or None
        The first one since `clear` that was an error.
    count : int
        How many have come, resets included.
    """

    __slots__ = ("active", "count")

    def __init__(self) -> None:
        self.active: Emergency | None = None
        self.count = 0

    def receive(self, data: bytes, now: float) -> None:
        """Take a frame with the node's EMCY identifier."""
        self.count += 1
        emergency = decode_emergency(data)
        if self.active is None and not emergency.is_reset:
            self.active = emergency

    def clear(self) -> None:
        """Forget; the count stays."""
        self.active = None
