"""The link to a process that grabs and detects."""

import pickle
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from typing import Final

from drivers.marker_camera.link import Event, Failure
from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.marker_camera.worker import decode_event

_PACKET: Final = 65536
_PATIENCE: Final = 2.0
"""How long the process may take to end before it is made to, s."""

_PROGRAM: Final = """
import sys
sys.path[:] = sys.argv[2:]
from drivers.marker_camera.worker import main
main(int(sys.argv[1]))
"""


class ProcessLink:
    """Runs the grabbing and detecting in a process of its own.

    It is a fresh interpreter. A fork would take the loop's locked memory and open devices along,
    and `multiprocessing` would run the main script again that started this one, which on a rig
    is more than a nuisance.

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
        self.process: subprocess.Popen[bytes] | None = None
        """The process while the link is open."""

    def open(self, now: float) -> None:
        """Start the process."""
        del now  # the process has the same monotonic clock
        self.close()
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        ours.setblocking(False)
        self._socket = ours
        ours.send(pickle.dumps(self._settings))
        with theirs:
            descriptor = theirs.fileno()
            self.process = subprocess.Popen(
                [sys.executable, "-c", _PROGRAM, str(descriptor), *sys.path],
                stdin=subprocess.DEVNULL,
                pass_fds=(descriptor,),
                # Ctrl-C goes to a whole group; the loop decides when the camera stops.
                process_group=0,
            )

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
        try:
            process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _describe_end(self) -> str | None:
        code = None if self.process is None else self.process.poll()
        if code is None:
            return None  # gone, but not reaped yet
        return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
