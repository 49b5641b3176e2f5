"""Events of a camera in another process, as packets of a local socket."""

import socket
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Final

from drivers.marker_camera.link import Event, Failure
from drivers.marker_camera.worker import decode_event

_PACKET: Final = 65536


class PacketLink(ABC):
    """The receiving end of a link to another process.

    Reading a packet costs microseconds, an empty socket less, and the socket's end tells at once
    that the other process is gone, on both sides.
    """

    def __init__(self) -> None:
        self._socket: socket.socket | None = None

    def poll(self, now: float) -> Sequence[Event]:
        """Return what the process sent since the last call; never waits."""
        del now
        events: list[Event] = []
        while self._socket is not None:
            try:
                packet = self._socket.recv(_PACKET)
            except BlockingIOError:
                break
            except ConnectionResetError:
                packet = b""
            if packet:
                events.append(decode_event(packet))
            else:
                self.hang_up()
                events.append(self._describe_end())
        return events

    def hang_up(self) -> None:
        """Close the socket, which the other process notices. Idempotent."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    @abstractmethod
    def _describe_end(self) -> Failure:
        """Return what has happened if the other process is gone."""
