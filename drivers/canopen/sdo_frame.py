"""One frame of an SDO transfer.

References
----------
CiA 301 V4.2, section 7.2.4.3.
"""

from typing import Final, NamedTuple

_ABORTS: Final = {
    0x0503_0000: "toggle bit not alternated",
    0x0504_0000: "time-out",
    0x0504_0001: "unknown command",
    0x0601_0000: "unsupported access",
    0x0601_0001: "write only",
    0x0601_0002: "read only",
    0x0602_0000: "no such object",
    0x0604_0041: "cannot be mapped",
    0x0604_0042: "the PDO would be too long",
    0x0604_0043: "incompatible parameters",
    0x0607_0010: "wrong length",
    0x0609_0011: "no such sub-index",
    0x0609_0030: "value out of range",
    0x0800_0000: "general error",
    0x0800_0020: "cannot be stored",
    0x0800_0022: "not in this state of the device",
}


class SdoFrame(NamedTuple):
    """The content of an SDO frame.

    Attributes
    ----------
    text : str
        In words.
    object, sub : int
        The object; None in the segments of a long transfer.
    data : bytes, optional
        The value, where the frame has all of it.
    """

    text: str
    object: int | None = None
    sub: int = 0
    data: bytes | None = None


def decode_sdo(data: bytes, *, from_server: bool) -> SdoFrame:
    """Return what the 8 bytes of an SDO frame say.

    Parameters
    ----------
    data : bytes
        The frame's content.
    from_server : bool
        The node sent it, and not the master.
    """
    command = data[0]
    index, sub = int.from_bytes(data[1:3], "little"), data[3]
    specifier = command >> 5
    if specifier == 4:
        code = int.from_bytes(data[4:8], "little")
        reason = _ABORTS.get(code, "unknown reason")
        return SdoFrame(f"aborted: {reason} (0x{code:08X})", index, sub)
    if from_server:
        if specifier == 3:
            return SdoFrame("written", index, sub)
        if specifier == 2:
            return _initiate("read", command, data, index, sub)
    else:
        if specifier == 2:
            return SdoFrame("read?", index, sub)
        if specifier == 1:
            return _initiate("write", command, data, index, sub)
    if specifier in (0, 1, 3):
        return SdoFrame("segment")
    return SdoFrame(f"command 0x{command:02X}")


def _initiate(word: str, command: int, data: bytes, index: int, sub: int) -> SdoFrame:
    if not command & 0x02:
        return SdoFrame(f"{word} {int.from_bytes(data[4:8], 'little')} bytes", index, sub)
    size = 4 - (command >> 2 & 0x03) if command & 0x01 else 4
    return SdoFrame(word, index, sub, bytes(data[4 : 4 + size]))
