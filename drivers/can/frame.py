"""A CAN frame as light as it can be, and the identifier flags of SocketCAN."""

from typing import Final

EXTENDED_FLAG: Final = 0x8000_0000
REMOTE_FLAG: Final = 0x4000_0000
ERROR_FLAG: Final = 0x2000_0000
STANDARD_MASK: Final = 0x0000_07FF
EXTENDED_MASK: Final = 0x1FFF_FFFF


class CanFrame:
    """A classic CAN frame; satisfies `rig.hal.Frame`.

    Parameters
    ----------
    arbitration_id : int
        11 or 29 bits; of an error frame the SocketCAN error class.
    data : bytes
        0 … 8 bytes.
    is_error_frame, is_remote_frame, is_extended_id : bool
        What kind of frame it is.
    """

    __slots__ = ("arbitration_id", "data", "is_error_frame", "is_extended_id", "is_remote_frame")

    def __init__(
        self,
        arbitration_id: int,
        data: bytes | bytearray = b"",
        is_error_frame: bool = False,
        is_remote_frame: bool = False,
        is_extended_id: bool = False,
    ) -> None:
        self.arbitration_id = arbitration_id
        self.data: bytes | bytearray = data
        self.is_error_frame = is_error_frame
        self.is_remote_frame = is_remote_frame
        self.is_extended_id = is_extended_id

    def __repr__(self) -> str:
        width = 8 if self.is_extended_id else 3
        return f"CanFrame({self.arbitration_id:0{width}X}#{bytes(self.data).hex().upper()})"
