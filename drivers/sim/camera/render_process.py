"""The process behind `ServedCamera`: renders frames, searches them, hands over what they show."""

import contextlib
import os
import pickle
import select
import socket
from collections.abc import Sequence
from pathlib import Path
from time import monotonic
from typing import Any, Final

from drivers.marker_camera.link import Event, Failure
from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.marker_camera.sighting import Sighting
from drivers.marker_camera.worker import encode_event
from drivers.sim.camera.emulated import EmulatedCamera
from drivers.sim.camera.ports import CameraBuild, MarkerPort
from drivers.sim.camera.poses import MarkerPose
from drivers.sim.camera.remote_camera import CLOSED, OPENED, READY

_LARGEST: Final = 65536  # bytes of a packet
_LOOK: Final = 2e-3  # how often frames under way are looked for, s
_LOST: Final = Failure(
    "the simulated camera cannot keep up with its frame rate on this machine; lower frame_rate"
)
_TAKEN: Final = Failure("another program has opened this camera")


class PoseFeed(MarkerPort):
    """A plant as far as a camera sees it."""

    def __init__(self) -> None:
        self.pose = MarkerPose((0.0, 0.0, 0.0), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))

    def marker_position(self) -> Sequence[float]:
        """Return the place that was told last, m."""
        return self.pose.position

    def ring_rotation(self) -> Sequence[Sequence[float]]:
        """Return the rotation that was told last."""
        return self.pose.rotation


class Exposing:
    """Frames for at most one program at a time.

    Parameters
    ----------
    simulation : socket
        From and to `ServedCamera`; its end is the end of this process.
    listener : socket
        Where programs open the camera.
    """

    def __init__(self, simulation: socket.socket, listener: socket.socket) -> None:
        self._simulation = simulation
        self._listener = listener
        build: CameraBuild = pickle.loads(simulation.recv(_LARGEST))
        self._feed = PoseFeed()
        self._camera = EmulatedCamera(build, self._feed)
        self._client: socket.socket | None = None
        self._origin = 0.0
        self._expected: int | None = None  # number of the next pose; None: frames are not wanted
        self._warm_up(build.settings)
        simulation.send(READY)

    def run(self) -> None:
        """Serve until the simulation ends."""
        while True:
            waits = [self._simulation, self._listener]
            if self._client is not None:
                waits.append(self._client)
            ready, _, _ = select.select(waits, (), (), None if self._client is None else _LOOK)
            if self._simulation in ready:
                packet = self._simulation.recv(_LARGEST)
                if not packet:
                    return
                self._hear(*pickle.loads(packet))
            if self._listener in ready:
                self._accept()
            if self._client in ready:
                self._listen()
            if self._client is not None:
                for event in self._camera.poll(monotonic() - self._origin):
                    self._hand_over(event)

    def _warm_up(self, settings: MarkerCameraSettings) -> None:
        """Expose one frame for nobody: what is compiled on first use must not make frames late."""
        self._feed.pose = self._feed.pose._replace(
            position=(0.0, 0.0, settings.marker.sphere_radius)
        )
        self._camera.open(0.0)
        self._camera.tick(settings.exposure)
        self._camera.close()

    def _hear(self, kind: str, origin: float, now: float, *more: Any) -> None:
        self._origin = origin
        if kind == "open":
            self._camera.open(now)
            self._expected = 0
        elif kind == "fault":
            self._camera.tell(now)
            self._camera.inject(*more)
        elif self._expected is not None:
            count, position, rotation = more
            if count != self._expected:
                self._expected = None
                self._hand_over(_LOST)
                return
            self._expected += 1
            self._feed.pose = MarkerPose(position, rotation)
            self._camera.tick(now)

    def _accept(self) -> None:
        client, _ = self._listener.accept()
        client.setblocking(False)
        if self._client is not None:
            with client:
                client.send(encode_event(_TAKEN))
            return
        self._client = client
        self._simulation.send(OPENED)

    def _listen(self) -> None:
        """Hear which file the client wants pictures in, or that it is gone."""
        assert self._client is not None
        try:
            told = self._client.recv(_LARGEST)
        except BlockingIOError:
            return
        except ConnectionResetError:
            told = b""
        if told:
            self._camera.look_into(Path(os.fsdecode(told)))
        else:
            self._dismiss()

    def _dismiss(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = self._expected = None
            self._camera.close()
            self._camera.look_into(None)
            self._simulation.send(CLOSED)

    def _hand_over(self, event: Event) -> None:
        if self._client is None:
            return
        if isinstance(event, Sighting):  # the world's time, in that of the wall clock
            event = event._replace(t=event.t + self._origin)
        try:
            self._client.send(encode_event(event))
        except BlockingIOError:
            pass  # it does not look: a frame is lost, as with any camera
        except (BrokenPipeError, ConnectionResetError):
            self._dismiss()


def main(simulation: int, listener: int) -> None:
    """Run as the process behind two inherited sockets."""
    import cv2

    cv2.setNumThreads(1)
    with contextlib.suppress(OSError):  # where permitted: after loop and devices, before the rest
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    with socket.socket(fileno=simulation) as ours, socket.socket(fileno=listener) as theirs:
        Exposing(ours, theirs).run()
