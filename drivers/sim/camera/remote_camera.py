"""A simulated camera for a program in another process.

The simulation of the rig must answer on its buses within a millisecond, and a frame takes
several to render and to search. So the simulation only tells where the marker is at each instant
of an exposure, and a process of its own makes frames of that and hands what they show to whoever
has opened the camera.
"""

import pickle
import socket
import subprocess
import sys
from math import inf
from typing import Any, Final

from drivers.sim.camera.faults import CameraFaults
from drivers.sim.camera.ports import CameraBuild, MarkerPort
from rig.hal import ConnectionFailed, DeviceFault

OPENED: Final = b"o"
"""The other process says that somebody opened the camera."""
CLOSED: Final = b"c"
"""… and that nobody has it any more."""

READY: Final = b"r"
"""Before anything else: its kernels are compiled."""

_PATIENCE: Final = 2.0  # for the process to end before it is made to, s
_PROGRAM: Final = """
import sys
sys.path[:] = sys.argv[3:]
from drivers.sim.camera.render_process import main
main(int(sys.argv[1]), int(sys.argv[2]))
"""


class ServedCamera(CameraFaults):
    """The simulation's side of a camera: tells its process where the marker is.

    It is an end for `drivers.sim.wall_clock.WallClockRig` and a camera for
    `drivers.sim.emulated_rig.EmulatedRig`. Faults: see `CameraFaults`.

    Parameters
    ----------
    build : CameraBuild
        The camera.
    plant : MarkerPort
        The physics; at time t when `tick(t)` is called.
    address : str
        Where it is served, see `drivers.sim.camera.remote_link`.

    Raises
    ------
    ConnectionFailed
        Somebody serves it there already.
    """

    def __init__(self, build: CameraBuild, plant: MarkerPort, address: str) -> None:
        super().__init__(build.name)
        self.address = address
        self._plant = plant
        self._rate = build.settings.frame_rate
        self._instants = build.instants
        self._start = inf
        self._count = 0  # of the instants since the start
        self._wanted: bool | None = None
        self._origin = 0.0
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listener:
            try:
                listener.bind(address)
            except OSError as error:
                raise ConnectionFailed(
                    self.name,
                    "another program simulates it on this interface already; end that one "
                    "or take another interface",
                    object=address[1:],
                    value=error.strerror,
                ) from error
            listener.listen()
            self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            with theirs:
                passed = (theirs.fileno(), listener.fileno())
                self._process = subprocess.Popen(
                    [sys.executable, "-c", _PROGRAM, *map(str, passed), *sys.path],
                    stdin=subprocess.DEVNULL,
                    pass_fds=passed,
                    process_group=0,  # Ctrl-C goes to a whole group; the simulation ends it
                )
        self._send(build)
        if self._socket.recv(1) != READY:
            raise ConnectionFailed(self.name, "the process that makes its frames has ended")
        self._socket.setblocking(False)

    # An end of the wall clock -----------------------------------------------------------

    def fileno(self) -> int:
        """Return what to wait for."""
        return self._socket.fileno()

    def take(self, origin: float) -> None:
        """Hear whether somebody has the camera.

        Raises
        ------
        DeviceFault
            Its process has ended.
        """
        self._origin = origin
        try:
            word = self._socket.recv(1)
        except BlockingIOError:
            return
        except ConnectionResetError:
            word = b""
        if not word:
            raise DeviceFault(self.name, "the process that makes its frames has ended")
        self._wanted = word == OPENED

    def give(self) -> None:
        """Do nothing: its process hands the frames over."""

    def close(self) -> None:
        """End the process. Idempotent."""
        self._socket.close()  # which the process notices
        try:
            self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    # A camera of the world --------------------------------------------------------------

    @property
    def due(self) -> float:
        """When the plant is looked at next, s; infinite while nobody has the camera."""
        if self._wanted is not None:
            return self.now
        frame, instant = divmod(self._count, len(self._instants))
        return self._start + frame / self._rate + self._instants[instant]

    def tick(self, now: float) -> None:
        """Tell where the marker is, if an instant of an exposure has come."""
        self.tell(now)
        wanted, self._wanted = self._wanted, None
        if wanted is not None:
            self._start, self._count = (now if wanted else inf), 0
            if wanted:
                self._send(("open", self._origin, now))
        if self.due > now:
            return
        position = tuple(map(float, self._plant.marker_position()))
        rotation = tuple(tuple(map(float, row)) for row in self._plant.ring_rotation())
        if not self._send(("pose", self._origin, self.due, self._count, position, rotation)):
            self._start = inf  # its process notices the gap, and says so
        self._count += 1

    def tell(self, now: float) -> None:
        """Take the time, s."""
        self.now = now

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now; see `CameraFaults`."""
        super().inject(fault, value)  # refuses what does not fit
        self._send(("fault", self._origin, self.now, fault, value))

    def _send(self, message: CameraBuild | tuple[Any, ...]) -> bool:
        """Tell the process; return whether it was told."""
        try:
            self._socket.send(pickle.dumps(message))
        except BlockingIOError:
            return False
        except (BrokenPipeError, ConnectionResetError):
            pass  # `take` says so
        return True
