"""Packets of Protocol 2.0 as a servo sees them: instructions in, status out.

References
----------
ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0": packets, byte stuffing, CRC, status errors.
"""

from typing import NamedTuple

BROADCAST = 254
PING, READ, WRITE, REG_WRITE, ACTION, REBOOT = 0x01, 0x02, 0x03, 0x04, 0x05, 0x08
STATUS = 0x55
SYNC_READ, SYNC_WRITE, FAST_SYNC_READ, BULK_READ = 0x82, 0x83, 0x8A, 0x92

# Error numbers of a status packet.
FAILED, UNKNOWN_INSTRUCTION, WRONG_CRC, OUT_OF_RANGE, TOO_SHORT, BEYOND_LIMIT, NO_ACCESS = range(
    1, 8
)
HARDWARE_ALERT = 128

_PREFIX = bytes.fromhex("FFFFFD00")
_LONGEST = 1024


def _remainders() -> list[int]:
    """Divide every byte, followed by 16 zero bits, by x^16 + x^15 + x^2 + 1 over GF(2)."""
    result = []
    for byte in range(256):
        dividend = byte << 16
        for shift in range(7, -1, -1):
            if dividend >> (16 + shift) & 1:
                dividend ^= 0x18005 << shift
        result.append(dividend)
    return result


_REMAINDERS = _remainders()


def checksum(data: bytes, start: int = 0) -> int:
    """Return the CRC of bytes, continued from `start`."""
    remainder = start
    for byte in data:
        remainder = _REMAINDERS[(remainder >> 8) ^ byte] ^ (remainder & 0xFF) << 8
    return remainder


class InstructionPacket(NamedTuple):
    """One packet of the host.

    Attributes
    ----------
    servo : int
        Whom it is for; 254 for all.
    instruction : int
        What to do.
    parameters : bytes
        With what, unstuffed.
    intact : bool
        Whether its CRC is right.
    end : int
        Where it ends in the bytes that were given, for its time on the wire.
    """

    servo: int
    instruction: int
    parameters: bytes
    intact: bool
    end: int


class InstructionReader:
    """Cuts what the host sends into packets; keeps what is not complete yet."""

    def __init__(self) -> None:
        self._kept = b""

    def take(self, data: bytes) -> list[InstructionPacket]:
        """Return the packets that these bytes complete."""
        stream = self._kept + data
        offset = len(self._kept)
        packets: list[InstructionPacket] = []
        at = 0
        while True:
            start = stream.find(_PREFIX, at)
            if start < 0:
                # A header may be cut in two.
                self._kept = stream[max(at, len(stream) - len(_PREFIX) + 1) :]
                return packets
            if len(stream) < start + 7:
                break
            length = int.from_bytes(stream[start + 5 : start + 7], "little")
            if not 3 <= length <= _LONGEST:
                at = start + 1
                continue
            end = start + 7 + length
            if len(stream) < end:
                break
            whole = stream[start:end]
            intact = checksum(whole[:-2]) == int.from_bytes(whole[-2:], "little")
            if whole[7] != STATUS:
                parameters = _without_stuffing(whole[8:-2])
                packets.append(
                    InstructionPacket(whole[4], whole[7], parameters, intact, end - offset)
                )
            at = end if intact else start + 1
        self._kept = stream[start:]
        return packets


def build_status(servo: int, error: int, data: bytes = b"") -> bytes:
    """Return a status packet."""
    body = _with_stuffing(bytes([STATUS, error]) + data)
    packet = _PREFIX + bytes([servo]) + (len(body) + 2).to_bytes(2, "little") + body
    return packet + checksum(packet).to_bytes(2, "little")


def begin_common_status(size: int, count: int) -> bytes:
    """Return what the first of `count` servos sends ahead of its own block in a fast reply."""
    length = 1 + count * (size + 4)
    return _PREFIX + bytes([BROADCAST]) + length.to_bytes(2, "little") + bytes([STATUS])


def build_block(heard: int, servo: int, error: int, data: bytes) -> bytes:
    """Return a servo's block in a fast reply, after what it heard of the reply so far.

    Parameters
    ----------
    heard : int
        The CRC of all that.
    servo, error : int
        Its id and error number.
    data : bytes
        What was asked for.
    """
    body = bytes([error, servo]) + data
    return body + checksum(body, heard).to_bytes(2, "little")


def _with_stuffing(content: bytes) -> bytes:
    result = bytearray()
    for byte in content:
        result.append(byte)
        if result[-3:] == b"\xff\xff\xfd":
            result.append(0xFD)
    return bytes(result)


def _without_stuffing(content: bytes) -> bytes:
    if b"\xff\xff\xfd\xfd" not in content:
        return content
    result = bytearray()
    skip = False
    for byte in content:
        if skip and byte == 0xFD:
            skip = False
            continue
        result.append(byte)
        skip = result[-3:] == b"\xff\xff\xfd"
    return bytes(result)
