"""The link to a process that grabs and detects."""

import multiprocessing
import signal
import socket
from collections.abc import Sequence
from multiprocessing.context import SpawnProcess
from typing import Final

from drivers.cameras.link import Event, Failure
from drivers.cameras.settings import MarkerCameraSettings
from drivers.cameras.worker import decode_event, run_worker

_PACKET: Final = 65536
_PATIENCE: Final = 2.0
"""How long the process may take to end before it is made to, s."""


class ProcessLink:
    """Runs the grabbing and detecting in a process of its own.

    Events come as packets of a local socket: reading one costs microseconds, an empty socket
    less, and the socket's end tells at once that the other process is gone, on both sides.

    Parameters
    ----------
    settings : MarkerCameraSettings
        All of the camera.
    """

    def __init__(self, settings: MarkerCameraSettings) -> None:
        self._settings = settings
        self._socket: socket.socket | None = None
        self.process: SpawnProcess | None = None
        """The process while the link is open."""

    def open(self, now: float) -> None:
        """Start the process."""
        del now  # the process has the same monotonic clock
        self.close()
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        ours.setblocking(False)
        # Spawned, not forked: a fork would take the loop's locked memory and open devices along.
        self.process = multiprocessing.get_context("spawn").Process(
            target=run_worker, args=(theirs, self._settings), name="marker-camera", daemon=True
        )
        try:
            self.process.start()
        finally:
            theirs.close()
        self._socket = ours

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
                self._socket.close()
                self._socket = None
                events.append(Failure("its grabbing process ended", value=self._describe_end()))
        return events

    def close(self) -> None:
        """End the process. Idempotent."""
        if self._socket is not None:
            self._socket.close()  # which the process notices
            self._socket = None
        process, self.process = self.process, None
        if process is None:
            return
        process.join(_PATIENCE)
        if process.is_alive():
            process.kill()
            process.join()
        process.close()

    def _describe_end(self) -> str | None:
        code = None if self.process is None else self.process.exitcode
        if code is None:
            return None  # gone, but not reaped yet
        return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
