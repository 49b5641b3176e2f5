"""A camera in virtual time: rendered frames through the production detector.

It stands where a real camera and the process that grabs and detects stand otherwise: the
production driver takes it as its link. The world of the simulation drives it as it drives a
bus: it halts at `due`, brings the plant there, and calls `tick`.
"""

from collections.abc import Sequence
from math import inf

from drivers.marker_camera.detector import MarkerDetector
from drivers.marker_camera.link import Event, Ready
from drivers.sim.camera.faults import UNPLUGGED, CameraFaults
from drivers.sim.camera.ports import CameraBuild, Delivery, MarkerPort
from drivers.sim.camera.poses import MarkerPose
from drivers.sim.camera.renderer import Image, MarkerRenderer


class EmulatedCamera:
    """Renders what a camera sees of a plant, and detects it as the real rig does.

    Faults: see `CameraFaults`.

    Parameters
    ----------
    build : CameraBuild
        The camera.
    plant : MarkerPort
        The physics; at time t when `tick(t)` is called.
    """

    def __init__(self, build: CameraBuild, plant: MarkerPort) -> None:
        self.name = build.name
        self._settings = build.settings
        self._plant = plant
        self._serial = build.serial
        self._renderer = MarkerRenderer(build.scene, build.optics, build.seed)
        self._detector = MarkerDetector(build.settings)
        self._delivery = Delivery(build)
        self._faults = CameraFaults(build.name)
        self._instants = build.instants
        self._poses: list[MarkerPose] = []
        self._frame = 0
        self._start = inf
        self._image: Image | None = None

    # The world's side -----------------------------------------------------------------

    @property
    def due(self) -> float:
        """When the plant is looked at next, s; infinite while nobody grabs."""
        return self._exposure_start() + self._instants[len(self._poses)]

    def tick(self, now: float) -> None:
        """Look at the plant if an instant of an exposure has come; the plant is at `now`."""
        self.tell(now)
        while self.due <= now:
            self._poses.append(
                MarkerPose(self._plant.marker_position(), self._plant.ring_rotation())
            )
            if len(self._poses) == len(self._instants):
                self._finish_frame()

    def tell(self, now: float) -> None:
        """Take the time (s): a fault that lasts is counted from now."""
        self._faults.now = now

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` understands."""
        return self._faults.known

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now; see `CameraFaults`."""
        self._faults.inject(fault, value)

    # The driver's side ----------------------------------------------------------------

    def open(self, now: float) -> None:
        """Begin to expose frames."""
        self.close()
        self.tell(now)
        if self._faults.has("unplugged"):
            self._delivery.send(UNPLUGGED, now)
            return
        self._start = now
        self._delivery.send(Ready(self._serial), now)

    def poll(self, now: float) -> Sequence[Event]:
        """Return what has arrived by `now` (s) and was not fetched yet."""
        return self._delivery.fetch(now)

    def close(self) -> None:
        """Stop exposing; frames under way are lost. Idempotent."""
        self._start = inf
        self._frame = 0
        self._poses.clear()
        self._delivery.lose()

    # Inside ---------------------------------------------------------------------------

    def _exposure_start(self) -> float:
        return self._start + self._frame / self._settings.frame_rate

    def _finish_frame(self) -> None:
        frame, poses, faults = self._frame, tuple(self._poses), self._faults
        stamp, arrival = self._delivery.times(
            self._exposure_start() + 0.5 * self._settings.exposure
        )
        self._poses.clear()
        self._frame += 1
        if faults.has("unplugged"):
            self.close()
            self._delivery.send(UNPLUGGED, faults.now)
        elif not self._delivery.is_dropped() and not faults.has("stalled"):
            sighting = self._detector.detect(self._expose(poses), frame, stamp)
            self._delivery.send(sighting, arrival + faults.delay)

    def _expose(self, poses: tuple[MarkerPose, ...]) -> Image:
        faults, renderer, marker = self._faults, self._renderer, self._settings.marker
        if faults.has("frozen") and self._image is not None:
            return self._image
        if faults.has("covered"):
            image = renderer.render_darkness()
        elif faults.has("lost"):
            image = renderer.render(())
        elif faults.has("swapped"):
            other = (marker.ids[0] + 1) % 50  # the smallest dictionaries have 50 markers
            image = renderer.render(poses, diameter=0.6 * marker.diameter, number=other)
        else:
            image = renderer.render(poses)
        if faults.has("mirrored"):
            image = image[:, ::-1].copy()
        self._image = image
        return image
