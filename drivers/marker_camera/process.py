"""The link to a process that grabs and detects."""

import pickle
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import Final

from drivers.marker_camera.link import Failure
from drivers.marker_camera.packet_link import PacketLink
from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.marker_camera.shown import offer_pictures

_PATIENCE: Final = 2.0
"""How long the process may take to end before it is made to, s."""

_PROGRAM: Final = """
import sys
sys.path[:] = sys.argv[2:]
from drivers.marker_camera.worker import main
main(int(sys.argv[1]))
"""


class ProcessLink(PacketLink):
    """Runs the grabbing and detecting in a process of its own.

    It is a fresh interpreter. A fork would take the loop's locked memory and open devices along,
    and `multiprocessing` would run the main script again that started this one, which on a rig
    is more than a nuisance.
    """

    def __init__(self, settings: MarkerCameraSettings) -> None:
        super().__init__()
        self._settings = settings
        self._picture: Path | None = None
        self.process: subprocess.Popen[bytes] | None = None
        """The process while the link is open."""

    def show_in(self, picture: Path) -> None:
        """Put pictures into this file from the next `open` on."""
        self._picture = offer_pictures(picture)

    def open(self, now: float) -> None:
        """Start the process."""
        del now  # the process has the same monotonic clock
        self.close()
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        ours.setblocking(False)
        self._socket = ours
        ours.send(pickle.dumps((self._settings, self._picture)))
        with theirs:
            descriptor = theirs.fileno()
            self.process = subprocess.Popen(
                [sys.executable, "-c", _PROGRAM, str(descriptor), *sys.path],
                stdin=subprocess.DEVNULL,
                pass_fds=(descriptor,),
                # Ctrl-C goes to a whole group; the loop decides when the camera stops.
                process_group=0,
            )

    def close(self) -> None:
        """End the process. Idempotent."""
        self.hang_up()
        process, self.process = self.process, None
        if process is None:
            return
        try:
            process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _describe_end(self) -> Failure:
        code = None if self.process is None else self.process.poll()
        if code is None:
            how = None  # gone, but not reaped yet
        else:
            how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        return Failure("its grabbing process ended", value=how)
