"""CAN frames between programs of one host, by multicast, in the words of python-can.

Anybody who reaches the host can send it datagrams. Taken is what was sent to the group by this
host and is a classic frame; all else is counted and dropped.

References
----------
``man 7 ip``: a socket that is bound to a group receives nothing that is sent to another address.
python-can, ``can.interfaces.udp_multicast``: a frame is a msgpack map.
"""

import socket
from collections.abc import Mapping
from typing import Final

from drivers.can.frame import EXTENDED_FLAG, EXTENDED_MASK, REMOTE_FLAG, STANDARD_MASK
from rig.hal import FastCanBus

FIRST_PORT: Final = 43113
"""python-can's own; buses of one program count on from it."""
_IP_MULTICAST_ALL: Final = 49  # linux/in.h: what others joined is not handed over
_IPV6_MULTICAST_ALL: Final = 29
_MOST: Final = 4096  # bytes of a datagram
_SENDERS: Final = 64
"""Addresses that are remembered as this host's or not."""


class MulticastBus(FastCanBus):
    """A group on this host, which no frame leaves.

    A program hears its own frames, too, and drops them by the port that they came from, which is
    nobody else's: what nobody else has sent must not be taken for another master's, however many
    frames wait, and whatever the kernel has lost of them.

    Parameters
    ----------
    group : str
        Its address, IPv4 or IPv6.
    port : int
        Linux hands what comes for one group to whoever listens to another on the same port.

    Raises
    ------
    OSError
        This host has no way for it.
    ImportError
        msgpack is not installed.
    """

    def __init__(self, group: str, port: int = FIRST_PORT) -> None:
        import msgpack

        self._pack, self._unpack = msgpack.packb, msgpack.unpackb
        self._is_local: dict[str, bool] = {}
        self._dropped = 0
        is_old = ":" not in group
        family = socket.AF_INET if is_old else socket.AF_INET6
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._sender = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._sender.setblocking(False)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            # No hops: a setpoint must not reach another lab's rig.
            if is_old:
                level, ttl, join = socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, b"\0\0\0\0"
                every, membership = _IP_MULTICAST_ALL, socket.IP_ADD_MEMBERSHIP
            else:
                level, ttl, join = socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_HOPS, b"\0\0\0\0"
                every, membership = _IPV6_MULTICAST_ALL, socket.IPV6_JOIN_GROUP
            self._socket.setsockopt(level, ttl, 0)
            self._sender.setsockopt(level, ttl, 0)
            self._sender.bind(("", 0))
            self._socket.setsockopt(level, every, 0)
            self._socket.bind((group, port))
            address = socket.inet_pton(family, group)
            self._socket.setsockopt(level, membership, address + join)
        except (OSError, OverflowError):
            self.shutdown()
            raise
        self._own_port = self._sender.getsockname()[1]
        self._group = (group, port)

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the waiting frames of others, at most `limit`, with the flags of SocketCAN."""
        frames: list[tuple[int, bytes]] = []
        for _ in range(limit):
            try:
                datagram, sender = self._socket.recvfrom(_MOST)
            except BlockingIOError:
                break
            is_local = self._comes_from_here(sender)
            if is_local and sender[1] == self._own_port:
                continue
            frame = self._frame_of(datagram) if is_local else None
            if frame is None:
                self._dropped += 1
            else:
                frames.append(frame)
        return frames

    def send_data(self, can_id: int, data: bytes) -> None:
        """Send one frame.

        Raises
        ------
        OSError
            The host does not take it.
        """
        content = {
            "timestamp": 0.0,
            "arbitration_id": can_id & EXTENDED_MASK,
            "is_extended_id": bool(can_id & EXTENDED_FLAG),
            "is_remote_frame": bool(can_id & REMOTE_FLAG),
            "is_error_frame": False,
            "channel": None,
            "dlc": len(data),
            "data": bytes(data),
            "is_fd": False,
            "bitrate_switch": False,
            "error_state_indicator": False,
        }
        self._sender.sendto(self._pack(content, use_bin_type=True), self._group)

    def count_dropped(self) -> int:
        """Return how many datagrams were no frame, or came from elsewhere."""
        return self._dropped

    def fileno(self) -> int:
        """Return the descriptor of the socket to wait for frames at; -1 once it is closed."""
        return self._socket.fileno()

    def shutdown(self) -> None:
        """Close the sockets. Idempotent."""
        self._socket.close()
        self._sender.close()

    def _frame_of(self, datagram: bytes) -> tuple[int, bytes] | None:
        """Return a datagram's frame, None if it holds none of classic CAN."""
        try:
            content = self._unpack(datagram, raw=False)
        except Exception:  # its unpacker raises whatever comes of bytes that are none of its
            return None
        return decode_frame(content) if isinstance(content, dict) else None

    def _comes_from_here(self, sender: tuple[object, ...]) -> bool:
        """Return whether an address is one of this host's: only then can it be bound to."""
        host = str(sender[0])
        if host not in self._is_local:
            if len(self._is_local) >= _SENDERS:
                self._is_local.clear()
            with socket.socket(self._socket.family, socket.SOCK_DGRAM) as probe:
                try:
                    probe.bind((host, 0, *sender[2:]))
                    self._is_local[host] = True
                except OSError:
                    self._is_local[host] = False
        return self._is_local[host]


def decode_frame(content: Mapping[object, object]) -> tuple[int, bytes] | None:
    """Return identifier (with flags) and data of what python-can says of a frame.

    None stands for what is no data frame or remote frame of classic CAN. An error frame is what a
    controller says of its own bus, and none can come from elsewhere.
    """
    can_id, data = content.get("arbitration_id"), content.get("data")
    flags = [
        content.get(key) for key in ("is_extended_id", "is_remote_frame", "is_error_frame", "is_fd")
    ]
    if not isinstance(can_id, int) or isinstance(can_id, bool) or not isinstance(data, bytes):
        return None
    if len(data) > 8 or not all(isinstance(flag, bool) for flag in flags):
        return None
    is_extended, is_remote, is_error, is_fd = flags
    if is_error or is_fd or not 0 <= can_id <= (EXTENDED_MASK if is_extended else STANDARD_MASK):
        return None
    if is_extended:
        can_id |= EXTENDED_FLAG
    return (can_id | REMOTE_FLAG if is_remote else can_id), data
