"""Frames as an identifier with flags and bytes, on any interface.

SocketCAN offers it itself; around python-can's interfaces it is made here.
"""

from collections.abc import Callable

from drivers.can.frame import (
    ERROR_FLAG,
    EXTENDED_FLAG,
    EXTENDED_MASK,
    REMOTE_FLAG,
)
from rig.hal import CanBus, Frame

Drain = Callable[[int], list[tuple[int, bytes]]]
Send = Callable[[int, bytes], None]


def drain_of(bus: CanBus) -> Drain:
    """Return ``drain(limit)``: the waiting frames, with the flags of `drivers.can.frame`."""
    own: Drain | None = getattr(bus, "drain", None)
    if own is not None:
        return own
    recv = bus.recv

    def drain(limit: int) -> list[tuple[int, bytes]]:
        frames: list[tuple[int, bytes]] = []
        for _ in range(limit):
            frame = recv(0.0)
            if frame is None:
                break
            frames.append((flagged_id(frame), bytes(frame.data)))
        return frames

    return drain


def backlog_of(bus: CanBus) -> Callable[[], int]:
    """Return what tells whether frames wait that the interface has not taken yet.

    Only SocketCAN's queue can be looked at; of another interface it always says 0.
    """
    own: Callable[[], int] | None = getattr(bus, "backlog", None)
    return own if own is not None else _no_backlog


def _no_backlog() -> int:
    return 0


def drops_of(bus: CanBus) -> Callable[[], int]:
    """Return what tells how many frames were dropped because nobody took them in time.

    Only SocketCAN says so; of another interface it is always 0.
    """
    own: Callable[[], int] | None = getattr(bus, "count_dropped", None)
    return own if own is not None else int


def flagged_id(frame: Frame) -> int:
    """Return a frame's identifier with the flags of `drivers.can.frame`."""
    can_id = frame.arbitration_id
    if frame.is_error_frame:
        can_id |= ERROR_FLAG
    elif frame.is_extended_id:
        can_id |= EXTENDED_FLAG
    return can_id | REMOTE_FLAG if frame.is_remote_frame else can_id


def send_of(bus: CanBus) -> Send:
    """Return ``send(can_id, data)``; the identifier may bear flags of `drivers.can.frame`."""
    own: Send | None = getattr(bus, "send_data", None)
    if own is not None:
        return own
    from drivers.can.message import Message

    send = bus.send

    def send_data(can_id: int, data: bytes) -> None:
        frame = Message(
            arbitration_id=can_id & EXTENDED_MASK,
            data=data,
            is_extended_id=bool(can_id & EXTENDED_FLAG),
            is_remote_frame=bool(can_id & REMOTE_FLAG),
        )
        send(frame)

    return send_data
