"""Codec of Dynamixel Protocol 2.0: bytes ↔ instruction and status packets.

Pure functions. A packet is ``FF FF FD 00 | id | length | instruction | parameters | CRC``, all
numbers little-endian; `length` counts from the instruction to the end of the CRC.

References
----------
ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0" (packets, byte stuffing, processing order) and
"CRC Calculation" (CRC-16 with polynomial 0x8005, start value 0, not reflected).
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import Final, NamedTuple

from fastcrc import crc16

HEADER: Final = b"\xff\xff\xfd\x00"
BROADCAST_ID: Final = 0xFE
MAX_ID: Final = 0xFC
INSTRUCTION_AT: Final = 7  # where the instruction is: after header, id and length
CRC_SIZE: Final = 2
FAST_OVERHEAD: Final = 4  # of a block in a fast reply: error, id, CRC

_MARK: Final = b"\xff\xff\xfd"  # must not occur inside a packet
_STUFFED: Final = b"\xff\xff\xfd\xfd"


class Instruction(IntEnum):
    """The instruction of a packet, or that it is an answer."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    STATUS = 0x55
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A


class Status(NamedTuple):
    """The answer of one servo.

    Attributes
    ----------
    id : int
        Whose answer it is.
    error : int
        Bit 7: the servo has a hardware error; the others: why it refused the instruction.
    data : bytes
        What was read.
    """

    id: int
    error: int
    data: bytes


def compute_crc(data: bytes, crc: int = 0) -> int:
    """Return the CRC-16 of bytes; catalogues call this one UMTS.

    Parameters
    ----------
    data : bytes
        What to check.
    crc : int
        Of what came before, to go on from there.
    """
    return crc16.umts(data, crc)


def stuff(content: bytes) -> bytes:
    """Return instruction and parameters such that no header occurs in them."""
    return content.replace(_MARK, _STUFFED) if _MARK in content else content


def unstuff(content: bytes) -> bytes:
    """Undo `stuff`."""
    return content.replace(_STUFFED, _MARK) if _STUFFED in content else content


def encode_packet(servo: int, instruction: int, parameters: bytes = b"") -> bytes:
    """Return a packet, stuffed and with its CRC.

    Parameters
    ----------
    servo : int
        Id, 0 … 252, or 254 for all.
    instruction : int
        One of `Instruction`.
    parameters : bytes
        What the instruction takes.
    """
    content = stuff(bytes((instruction,)) + parameters)
    length = len(content) + CRC_SIZE
    packet = HEADER + bytes((servo, length & 0xFF, length >> 8)) + content
    return packet + compute_crc(packet).to_bytes(2, "little")


def encode_ping(servo: int) -> bytes:
    """Return the packet that asks a servo (or all) for its model and firmware."""
    return encode_packet(servo, Instruction.PING)


def encode_read(servo: int, address: int, size: int) -> bytes:
    """Return the packet that reads `size` bytes of a servo's control table."""
    return encode_packet(servo, Instruction.READ, _range(address, size))


def encode_write(servo: int, address: int, data: bytes) -> bytes:
    """Return the packet that writes into a servo's control table at once."""
    return encode_packet(servo, Instruction.WRITE, address.to_bytes(2, "little") + data)


def encode_sync_read(address: int, size: int, servos: Sequence[int], *, fast: bool) -> bytes:
    """Return the packet that reads the same registers of several servos.

    Parameters
    ----------
    address, size : int
        Of the registers, bytes.
    servos : sequence of int
        Ids, in the order in which they shall answer.
    fast : bool
        Have them answer in one common packet.
    """
    instruction = Instruction.FAST_SYNC_READ if fast else Instruction.SYNC_READ
    return encode_packet(BROADCAST_ID, instruction, _range(address, size) + bytes(servos))


def encode_sync_write(address: int, size: int, payload: bytes) -> bytes:
    """Return the packet that writes the same registers of several servos.

    Parameters
    ----------
    address, size : int
        Of the registers, bytes.
    payload : bytes
        Per servo its id and `size` bytes.
    """
    return encode_packet(BROADCAST_ID, Instruction.SYNC_WRITE, _range(address, size) + payload)


def decode_status(packet: bytes) -> Status:
    """Return what a whole status packet says; its CRC has been checked.

    Parameters
    ----------
    packet : bytes
        From the header to the CRC.
    """
    content = unstuff(packet[INSTRUCTION_AT:-CRC_SIZE])
    return Status(packet[4], content[1], content[2:])


def decode_fast_status(packet: bytes, size: int) -> list[Status | None]:
    """Return what a fast reply says, also if it is cut off or damaged in places.

    All servos write into one packet, one after the other, each with a CRC of everything up
    to its own block; there is no byte stuffing in it. A servo that has not heard the one
    before it stays silent, so a missing servo cuts the packet off.

    Parameters
    ----------
    packet : bytes
        From the header to the last byte that came.
    size : int
        Bytes that were asked of each servo.

    Returns
    -------
    list of Status or None
        Block by block, in the order of the request; None if its CRC is wrong.

    Notes
    -----
    A servo computes its CRC over what it heard. If a block was damaged on the way to us
    only, the next servo heard it undamaged, and its CRC goes on from the one that the
    damaged block brought; if it was damaged for all, from the one that we compute.
    """
    stride = size + FAST_OVERHEAD
    blocks: list[Status | None] = []
    at = INSTRUCTION_AT + 1
    crc = heard = compute_crc(packet[:at])
    for end in range(at + stride, len(packet) + 1, stride):
        body, tail = packet[at : end - CRC_SIZE], packet[end - CRC_SIZE : end]
        found = tail[0] | tail[1] << 8
        ours = compute_crc(body, crc)
        if ours == found or (heard != crc and compute_crc(body, heard) == found):
            blocks.append(Status(body[1], body[0], body[2:]))
        else:
            blocks.append(None)
        crc = compute_crc(tail, ours)
        heard = crc if ours == found else compute_crc(tail, found)
        at = end
    return blocks


def compute_fast_length(size: int, count: int) -> int:
    """Return the bytes of a fast reply of `count` servos with `size` bytes each."""
    return INSTRUCTION_AT + 1 + count * (size + FAST_OVERHEAD)


def _range(address: int, size: int) -> bytes:
    return address.to_bytes(2, "little") + size.to_bytes(2, "little")
