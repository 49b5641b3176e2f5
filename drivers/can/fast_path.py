"""Frames as an identifier with flags and bytes, of any interface that python-can knows."""

from collections.abc import Callable

from drivers.can.frame import ERROR_FLAG, EXTENDED_FLAG, EXTENDED_MASK, REMOTE_FLAG
from rig.hal import CanBus, FastCanBus, Frame

Drain = Callable[[int], list[tuple[int, bytes]]]
Send = Callable[[int, bytes], None]


class AdaptedBus(FastCanBus):
    """An interface of python-can as the program uses it.

    It can neither filter nor tell what waits or was lost, as SocketCAN's socket can.

    Parameters
    ----------
    bus : CanBus
        Open. It is owned from now on.
    """

    def __init__(self, bus: CanBus) -> None:
        from drivers.can.message import Message

        self._bus = bus
        self._message = Message

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the waiting frames, at most `limit`, with the flags of `drivers.can.frame`."""
        recv = self._bus.recv
        frames: list[tuple[int, bytes]] = []
        for _ in range(limit):
            frame = recv(0.0)
            if frame is None:
                break
            frames.append((flagged_id(frame), bytes(frame.data)))
        return frames

    def send_data(self, can_id: int, data: bytes) -> None:
        """Send one frame; the identifier may bear flags of `drivers.can.frame`."""
        self._bus.send(
            self._message(
                arbitration_id=can_id & EXTENDED_MASK,
                data=data,
                is_extended_id=bool(can_id & EXTENDED_FLAG),
                is_remote_frame=bool(can_id & REMOTE_FLAG),
            )
        )

    def fileno(self) -> int:
        """Return what to wait for, or -1: not every interface has a descriptor."""
        try:
            return self._bus.fileno()
        except (NotImplementedError, OSError):
            return -1

    def shutdown(self) -> None:
        """Release the interface."""
        self._bus.shutdown()


def flagged_id(frame: Frame) -> int:
    """Return a frame's identifier with the flags of `drivers.can.frame`."""
    can_id = frame.arbitration_id
    if frame.is_error_frame:
        can_id |= ERROR_FLAG
    elif frame.is_extended_id:
        can_id |= EXTENDED_FLAG
    return can_id | REMOTE_FLAG if frame.is_remote_frame else can_id
