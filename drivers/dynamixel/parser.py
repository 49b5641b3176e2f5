"""Find status packets in a stream of bytes that may be noisy, cut off or late."""

from typing import Final

from drivers.dynamixel.codec import (
    BROADCAST_ID,
    CRC_SIZE,
    HEADER,
    INSTRUCTION_AT,
    Instruction,
    compute_crc,
)

_SHORTEST: Final = 4  # length of a status without data: instruction, error, CRC
_MARK: Final = HEADER[:3]
_LENGTH_END: Final = INSTRUCTION_AT


class StatusParser:
    """Takes bytes as they come and gives whole packets; finds the next header after a fault.

    Packets that are no status are skipped: some half-duplex adapters echo what they send.

    Parameters
    ----------
    longest : int
        A header that announces a longer packet than this is none, bytes.

    Attributes
    ----------
    corrupt : int
        Packets with a wrong CRC or an impossible length, so far.
    noise : int
        Bytes that belonged to no packet, so far.
    """

    __slots__ = ("_buffer", "_longest", "corrupt", "noise")

    def __init__(self, longest: int = 2048) -> None:
        self._longest = longest
        self._buffer = b""
        self.corrupt = 0
        self.noise = 0

    @property
    def pending(self) -> bool:
        """Return whether there is the beginning of a packet."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> list[bytes]:
        """Return the packets that are complete now, from header to CRC.

        The CRC of a fast reply (id 0xFE) is left to `decode_fast_status`, which can save
        the undamaged part of a damaged one.
        """
        self._buffer += data
        return self._scan()

    def finish(self) -> tuple[list[bytes], bytes]:
        """Give up waiting for the rest of a packet, and start afresh.

        Returns
        -------
        list of bytes
            Packets that stood behind a header whose packet never became complete.
        bytes
            The beginning of a fast reply that was cut off, if there is one.
        """
        packets: list[bytes] = []
        part = b""
        while self._buffer:
            # What `_scan` left begins like a packet, but its end never came.
            start = self._buffer
            if start[4:5] == bytes((BROADCAST_ID,)) and len(start) > INSTRUCTION_AT:
                self._buffer = b""
                part = start
                break
            self.corrupt += len(start) > len(HEADER)
            self._skip(1)
            packets += self._scan()
        return packets, part

    def _scan(self) -> list[bytes]:
        packets: list[bytes] = []
        while True:
            self._align()
            buffer = self._buffer
            if len(buffer) < _LENGTH_END:
                return packets
            length = buffer[5] | buffer[6] << 8
            end = _LENGTH_END + length
            if not length > CRC_SIZE or end > self._longest:
                self.corrupt += 1
                self._skip(1)
                continue
            if len(buffer) < end:
                return packets
            packet = buffer[:end]
            is_status = packet[INSTRUCTION_AT] == Instruction.STATUS and length >= _SHORTEST
            if is_status and packet[4] == BROADCAST_ID:
                packets.append(packet)
            elif compute_crc(packet[:-CRC_SIZE]) != packet[-2] | packet[-1] << 8:
                self.corrupt += 1
                self._skip(1)
                continue
            elif is_status:
                packets.append(packet)
            self._buffer = buffer[end:]

    def _align(self) -> None:
        """Drop what stands before the next header, or before what may become one."""
        buffer = self._buffer
        if buffer.startswith(HEADER):
            return
        at = buffer.find(HEADER)
        if at < 0:
            # Keep an end that the next bytes may complete: FF, FF FF, FF FF FD.
            at = len(buffer)
            for kept in (3, 2, 1):
                if buffer.endswith(_MARK[:kept]):
                    at -= kept
                    break
        self._skip(at)

    def _skip(self, count: int) -> None:
        self.noise += count
        self._buffer = self._buffer[count:]
