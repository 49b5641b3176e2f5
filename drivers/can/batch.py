"""Receive all waiting packets of a socket in one system call.

The socket module takes one packet a call, and one more call to learn that nothing is left: four
calls and an exception for the three frames of a cycle. ``recvmmsg`` takes them at once.

References
----------
Linux man-pages, recvmmsg(2) and recvmsg(2).
"""

import ctypes
import errno
import os
import socket
from typing import Final

_MSG_DONTWAIT: Final = int(socket.MSG_DONTWAIT)
_NOTHING: Final = (errno.EAGAIN, errno.EWOULDBLOCK, errno.EINTR)


class _Vector(ctypes.Structure):
    """``struct iovec``."""

    _fields_ = (("base", ctypes.c_void_p), ("length", ctypes.c_size_t))


class _Header(ctypes.Structure):
    """``struct msghdr``."""

    _fields_ = (
        ("name", ctypes.c_void_p),
        ("name_length", ctypes.c_uint32),
        ("vectors", ctypes.POINTER(_Vector)),
        ("vector_count", ctypes.c_size_t),
        ("control", ctypes.c_void_p),
        ("control_length", ctypes.c_size_t),
        ("flags", ctypes.c_int),
    )


class _Message(ctypes.Structure):
    """``struct mmsghdr``: a header and the length of what was received."""

    _fields_ = (("header", _Header), ("length", ctypes.c_uint))


class PacketBatch:
    """Room for packets of one size, and what fills it.

    Parameters
    ----------
    sock : socket.socket
        Of a kind that keeps packets apart, and has none of another size.
    size : int
        Of a packet, bytes.
    capacity : int
        Most packets in one call.
    """

    def __init__(self, sock: socket.socket, size: int, capacity: int) -> None:
        self._size = size
        self._capacity = capacity
        self._packets = ctypes.create_string_buffer(size * capacity)
        self._vectors = (_Vector * capacity)()
        self._messages = (_Message * capacity)()
        base = ctypes.addressof(self._packets)
        for k in range(capacity):
            self._vectors[k] = _Vector(base + k * size, size)
            self._messages[k].header.vectors = ctypes.pointer(self._vectors[k])
            self._messages[k].header.vector_count = 1
        self._bytes = memoryview(self._packets)
        # It never waits, so it need not give the interpreter away meanwhile, as CDLL does.
        self._recvmmsg = ctypes.PyDLL(None, use_errno=True).recvmmsg
        self._socket = ctypes.c_int(sock.fileno())
        self._address = ctypes.c_void_p(ctypes.addressof(self._messages))

    def receive(self, limit: int) -> memoryview | bytes:
        """Return the waiting packets, at most `limit`, one after the other; valid until the next.

        Raises
        ------
        OSError
            What the system says, other than that nothing waits.
        """
        most = limit if limit < self._capacity else self._capacity
        count: int = self._recvmmsg(self._socket, self._address, most, _MSG_DONTWAIT, None)
        if count > 0:
            return self._bytes[: count * self._size]
        return self._failed() if count else b""

    def close(self) -> None:
        """Forget the socket: its number may soon be another file's."""
        self._socket = ctypes.c_int(-1)

    def _failed(self) -> bytes:
        number = ctypes.get_errno()
        if number in _NOTHING:
            return b""
        raise OSError(number, os.strerror(number))
