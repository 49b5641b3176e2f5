"""The link to a camera that another process simulates, over a local socket.

It stands where the process that grabs and detects stands otherwise, and hands over the same
events. The socket has a name of Linux's abstract kind: it belongs to the network namespace, as
a virtual CAN interface does, so what can reach the one can reach the other.
"""

import socket
from collections.abc import Sequence
from pathlib import Path

from drivers.marker_camera.link import Event, Failure
from drivers.marker_camera.packet_link import PacketLink
from drivers.marker_camera.shown import offer_pictures


def camera_address(channel: str, camera: str) -> str:
    """Return the socket of a simulated camera.

    Parameters
    ----------
    channel : str
        The first CAN interface of its rig.
    camera : str
        Its name in the profile.
    """
    return f"\0rig-simulate/{channel}/{camera}"


class ReachedCamera(PacketLink):
    """A camera of `rig simulate`; satisfies `drivers.marker_camera.link.CameraLink`."""

    def __init__(self, address: str) -> None:
        super().__init__()
        self._address = address
        self._failure: Failure | None = None
        self._picture: Path | None = None

    def show_in(self, picture: Path) -> None:
        """Put pictures into this file from the next `open` on."""
        self._picture = offer_pictures(picture)

    def open(self, now: float) -> None:
        """Reach for the camera, which begins to expose frames."""
        del now  # both processes have the same monotonic clock
        self.close()
        link = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            link.connect(self._address)
        except OSError as error:
            link.close()
            self._failure = Failure(
                "nobody simulates it; start `rig simulate` with the same --on, or leave the "
                "camera out of the mechanism",
                object=self._address[1:],
                value=error.strerror,
            )
            return
        link.setblocking(False)
        self._socket = link
        if self._picture is not None:  # whose process may have another folder to work in
            link.send(str(self._picture.resolve()).encode())

    def poll(self, now: float) -> Sequence[Event]:
        """Return what has come since the last call; never waits."""
        failure, self._failure = self._failure, None
        before = [] if failure is None else [failure]
        return [*before, *super().poll(now)]

    def close(self) -> None:
        """Let go of the camera. Idempotent."""
        self.hang_up()

    def _describe_end(self) -> Failure:
        return Failure("its simulation ended")
