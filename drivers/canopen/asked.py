"""Objects of a node that are asked for in passing: nobody waits for the answer."""

import struct
from collections.abc import Callable
from typing import Final

_UPLOAD: Final = 0x40
_UPLOADED: Final = 0x42  # expedited: at most four bytes, which follow
_SIZE: Final = 8

Answered = Callable[[bytes, float], None]


class AskedObjects:
    """The objects of one node that are asked for in passing.

    Not while the node is read or written: it has one conversation at a time. None of these may
    be read in any other way until it is forgotten, or its answer would be taken for one of theirs.

    Parameters
    ----------
    send : callable
        Sends a frame now on the bus that the node hangs on; raises ConnectionFailed.
    node : int
        Its number.
    """

    def __init__(self, send: Callable[[int, bytes], None], node: int) -> None:
        self._send = send
        self._request_id = 0x600 + node
        self._answered: dict[bytes, Answered] = {}

    def ask(self, index: int, sub: int, answered: Answered) -> None:
        """Ask for an object; ``answered(data, now)`` is called when, and if, its bytes come."""
        request = struct.pack("<BHB4x", _UPLOAD, index, sub)
        self._answered[request[1:4]] = answered
        self._send(self._request_id, request)

    def forget(self, index: int, sub: int) -> None:
        """Leave the answers of an object to whoever reads it, be it asked for or not."""
        self._answered.pop(struct.pack("<HB", index, sub), None)

    def take(self, data: bytes, now: float) -> bool:
        """Take an SDO answer; return whether it is one of these."""
        answered = self._answered.get(data[1:4])
        if answered is None:
            return False
        if len(data) == _SIZE and data[0] & _UPLOADED == _UPLOADED:
            answered(data[4:], now)
        return True
