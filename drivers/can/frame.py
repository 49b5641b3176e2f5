"""The identifier flags of SocketCAN, and its error frames."""

from typing import Final

from rig.hal.frames import Decoded

EXTENDED_FLAG: Final = 0x8000_0000
REMOTE_FLAG: Final = 0x4000_0000
ERROR_FLAG: Final = 0x2000_0000
STANDARD_MASK: Final = 0x0000_07FF
EXTENDED_MASK: Final = 0x1FFF_FFFF


def decode_error_frame(can_id: int, data: bytes) -> Decoded | None:
    """Return what an error frame of the interface says; None: it is no error frame."""
    if not can_id & ERROR_FLAG:
        return None
    kind = can_id & EXTENDED_MASK & ~ERROR_FLAG
    return Decoded("", "error frame", text=f"class 0x{kind:X}, {data.hex(' ').upper()}")
