"""SocketCAN without a library in between: a raw socket, one system call for all that waits.

python-can on SocketCAN costs about 12 µs to receive and 9 µs to send a frame; this costs a
tenth of it. The kernel does the filtering.

References
----------
Linux ``Documentation/networking/can.rst``, sections "RAW protocol sockets" and
"CAN network driver interface"; ``linux/can/error.h`` for error frames.
"""

import contextlib
import socket
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from drivers.can.batch import PacketBatch
from drivers.can.bitrate import bitrate_of
from drivers.can.frame import (
    EXTENDED_FLAG,
    REMOTE_FLAG,
    STANDARD_MASK,
)
from rig.hal import ConnectionFailed, FastCanBus

_FRAME: Final = struct.Struct("=IB3x8s")  # struct can_frame: id with flags, length, data
_FILTER: Final = struct.Struct("=II")  # struct can_filter: id, mask
_SIZE: Final = _FRAME.size
_MOST_AT_ONCE: Final = 256
_pack = _FRAME.pack
_ERROR_MASK: Final = 0x1FFF_FFFF  # every error class
_CAN_RAW_ERR_FILTER: Final = 2  # linux/can/raw.h; the socket module does not name it
_MAX_FILTERS: Final = 512  # CAN_RAW_FILTER_MAX
_CAN_RAW_JOIN_FILTERS: Final = 6  # linux/can/raw.h: a frame must pass all filters, not one
_INVERTED: Final = 0x2000_0000  # CAN_INV_FILTER, of a filter's identifier
_SO_MEMINFO: Final = 55  # asm-generic/socket.h: memory that a socket holds
_MEMORY: Final = struct.Struct("=9I")  # linux/sock_diag.h
_SO_RCVBUFFORCE: Final = 33  # asm-generic/socket.h: SO_RCVBUF beyond what the system allows
_ROOM: Final = 1 << 22  # for frames that wait, bytes: five thousand, half a second of a full bus
_WAITS, _DROPS = 2, 8  # in it: bytes to be sent, packets that did not fit
_VIRTUAL: Final = ("vcan", "vxcan")  # names of interfaces without a bit rate
_ARPHRD_CAN: Final = 280  # linux/if_arp.h
_IFF_UP: Final = 0x1


class SocketCanBus(FastCanBus):
    """A CAN bus on a non-blocking socket.

    Parameters
    ----------
    sock : socket.socket
        A bound AF_CAN raw socket, which carries `struct can_frame` and nothing else unless it is
        told to; tests hand over one end of a socket pair. It is owned from now on.
    channel : str
        Name of the interface, for messages.
    """

    def __init__(self, sock: socket.socket, channel: str) -> None:
        sock.setblocking(False)
        self.channel = channel
        self._socket = sock
        self._send = sock.send
        self._batch = PacketBatch(sock, _SIZE, _MOST_AT_ONCE)
        self._receive = self._batch.receive
        self._others: socket.socket | None = None
        self._dropped = 0  # of the others, by the kernel
        self._is_can = sock.family == socket.AF_CAN

    def send_data(self, can_id: int, data: bytes) -> None:
        """Queue a frame given by identifier (with flags) and data.

        Raises
        ------
        OSError
            ENOBUFS or EAGAIN: the queue is full; ENETDOWN: the interface is down. It is
            never tried again here: the next cycle has newer setpoints.
        """
        self._send(_pack(can_id, len(data), data))

    def drain(self, limit: int = 256) -> list[tuple[int, bytes]]:
        """Return the waiting frames, at most `limit`, as (identifier with flags, data).

        Raises
        ------
        OSError
            ENETDOWN: the interface went down.
        """
        return [
            (can_id, data[:length])
            for can_id, length, data in _FRAME.iter_unpack(self._receive(limit))
        ]

    def backlog(self) -> int:
        """Return how many bytes of memory hold frames that the interface has not taken yet."""
        if not self._is_can:
            return 0
        return _memory_of(self._socket)[_WAITS]  # AF_CAN has no ioctl for it

    def accept(self, can_ids: Iterable[int]) -> None:
        """Have the kernel pass data frames with these 11-bit identifiers only, and errors.

        Frames that wait already are not affected. Those that are held back are counted.
        """
        mask = STANDARD_MASK | EXTENDED_FLAG | REMOTE_FLAG
        wanted = sorted(set(can_ids))
        if not self._is_can or len(wanted) > _MAX_FILTERS:
            return
        filters = b"".join(_FILTER.pack(can_id, mask) for can_id in wanted)
        self._socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, filters)
        self._others = _open_others(self.channel, wanted, mask)

    def count_others(self) -> int:
        """Return how many frames `accept` has held back since the last call."""
        if self._others is None:
            return 0
        count = 0
        with contextlib.suppress(OSError):  # nothing waits any more, or the interface is down
            while self._others.recv(_SIZE):
                count += 1
        dropped = _memory_of(self._others)[_DROPS]
        count, self._dropped = count + dropped - self._dropped, dropped
        return count

    def count_dropped(self) -> int:
        """Return how many frames the kernel has dropped: nobody took them while there was room."""
        return _memory_of(self._socket)[_DROPS] if self._is_can else 0

    def fileno(self) -> int:
        """Return the socket's descriptor, to wait for frames; -1 once it is closed."""
        return self._socket.fileno()

    def shutdown(self) -> None:
        """Close the socket. Idempotent."""
        self._batch.close()
        self._socket.close()
        if self._others is not None:
            self._others.close()


def open_socketcan(channel: str, bitrate: int) -> SocketCanBus:
    """Open a SocketCAN interface, which must be there and up.

    Parameters
    ----------
    channel : str
        ``can0``, ``vcan0``, …
    bitrate : int
        What it should run at, bit/s. The kernel is told by ``ip link``, and asked here.

    Raises
    ------
    ConnectionFailed
        It is missing or down or runs at another bit rate, or this machine has no SocketCAN.
        The message says which command mends it.
    """
    try:
        sock = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    except OSError as error:
        raise ConnectionFailed(
            channel,
            f"this kernel has no SocketCAN ({error.strerror}); load it with: "
            "sudo modprobe can_raw, or, where that cannot be (containers), simulate with "
            "--on udp_multicast:239.74.163.2 (pip install 'python-can[multicast]')",
        ) from error
    try:
        sock.bind((channel,))
        sock.setsockopt(socket.SOL_CAN_RAW, _CAN_RAW_ERR_FILTER, struct.pack("=I", _ERROR_MASK))
        _make_room(sock)
    except OSError as error:
        sock.close()
        kind = _read_number(channel, "type")
        if kind not in (None, _ARPHRD_CAN):
            raise ConnectionFailed(
                channel, "this is no CAN interface; ip -brief link show type can lists those"
            ) from error
        raise ConnectionFailed(
            channel,
            f"there is no such CAN interface ({error.strerror}); set it up with: "
            + link_command(channel, bitrate, add=True),
        ) from error
    if not _is_up(channel):
        sock.close()
        raise ConnectionFailed(
            channel, f"the interface is down; set it up with: {link_command(channel, bitrate)}"
        )
    wrong = wrong_bitrate(channel, bitrate)
    if wrong is not None:
        sock.close()
        raise ConnectionFailed(channel, wrong)
    return SocketCanBus(sock, channel)


def wrong_bitrate(channel: str, bitrate: int) -> str | None:
    """Return a sentence about an interface that runs at another bit rate, or None."""
    found = None if channel.startswith(_VIRTUAL) else bitrate_of(channel)
    if found in (None, bitrate):
        return None
    return (
        f"the interface runs at {found} bit/s and the profile asks for {bitrate}; set it with: "
        f"sudo ip link set {channel} down && {link_command(channel, bitrate)}"
    )


def _make_room(sock: socket.socket) -> None:
    """Have frames wait for a program that is held up, as far as the system allows."""
    try:
        sock.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, _ROOM)
    except PermissionError:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _ROOM)


def _open_others(channel: str, ids: Iterable[int], mask: int) -> socket.socket:
    """Open a socket for the frames that pass none of these filters.

    Nobody reads it in the cycle: what does not fit into its small queue is counted by the kernel.
    """
    others = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    filters = b"".join(_FILTER.pack(can_id | _INVERTED, mask) for can_id in ids)
    others.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, filters)
    others.setsockopt(socket.SOL_CAN_RAW, _CAN_RAW_JOIN_FILTERS, 1)
    others.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 0)  # the least there is
    others.setblocking(False)
    others.bind((channel,))
    return others


def link_command(channel: str, bitrate: int, *, add: bool = False) -> str:
    """Return the shell command that sets an interface up.

    Automatic restart after bus-off is on: the controller then says so with an error frame,
    and the rig stays in its latched fault.
    """
    if channel.startswith("vcan"):
        create = f"sudo ip link add dev {channel} type vcan && " if add else ""
        return f"{create}sudo ip link set {channel} up"
    return (
        f"sudo ip link set {channel} type can bitrate {bitrate} restart-ms 100 && "
        f"sudo ip link set {channel} txqueuelen 100 up"
    )


def _memory_of(sock: socket.socket) -> tuple[int, ...]:
    return _MEMORY.unpack(sock.getsockopt(socket.SOL_SOCKET, _SO_MEMINFO, _MEMORY.size))


def _is_up(channel: str) -> bool:
    flags = _read_number(channel, "flags")
    return flags is None or bool(flags & _IFF_UP)  # unknown: sending will tell


def _read_number(channel: str, attribute: str) -> int | None:
    """Return what the kernel says of an interface, if it does."""
    try:
        return int(Path("/sys/class/net", channel, attribute).read_text(), 0)
    except (OSError, ValueError):
        return None
