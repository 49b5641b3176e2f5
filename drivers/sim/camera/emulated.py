"""A camera in virtual time: rendered frames through the production detector.

It stands where a real camera and the process that grabs and detects stand otherwise: the
production driver takes it as its link. The world of the simulation drives it as it drives a
bus: it halts at `due`, brings the plant there, and calls `tick`.
"""

from collections.abc import Sequence
from pathlib import Path

from drivers.marker_camera.detector import MarkerDetector
from drivers.marker_camera.link import Event
from drivers.marker_camera.shown import ShownFrames, offer_pictures
from drivers.sim.camera.ports import CameraBuild, MarkerPort
from drivers.sim.camera.poses import MarkerPose
from drivers.sim.camera.renderer import Image, MarkerRenderer
from drivers.sim.camera.simulated_link import SimulatedLink


class EmulatedCamera(SimulatedLink):
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
        super().__init__(build, plant)
        self._renderer = MarkerRenderer(build.scene, build.optics, build.seed)
        self._detector = MarkerDetector(build.settings)
        self._instants = build.instants
        self._poses: list[MarkerPose] = []
        self._image: Image | None = None
        self._shown = ShownFrames(None)

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
        self.now = now

    # The driver's side ----------------------------------------------------------------

    def show_in(self, picture: Path) -> None:
        """Put pictures into this file: the frames that go through the detector."""
        self.look_into(offer_pictures(picture))

    def look_into(self, picture: Path | None) -> None:
        """Put pictures into a file that is there already, if there is one."""
        self._shown.close()
        self._shown = ShownFrames(picture)

    def poll(self, now: float) -> Sequence[Event]:
        """Return what has arrived by `now` (s) and was not fetched yet."""
        return self._delivery.fetch(now)

    def close(self) -> None:
        """Stop exposing; frames under way are lost. Idempotent."""
        super().close()
        self._poses.clear()

    # Inside ---------------------------------------------------------------------------

    def _exposure_start(self) -> float:
        return self._start + self._frame / self._settings.frame_rate

    def _finish_frame(self) -> None:
        frame, poses = self._frame, tuple(self._poses)
        stamp, arrival = self._delivery.times(
            self._exposure_start() + 0.5 * self._settings.exposure
        )
        self._poses.clear()
        self._frame += 1
        if self._is_unplugged() or self._delivery.is_dropped() or self.has("stalled"):
            return
        image = self._expose(poses)
        sighting = self._detector.detect(image, frame, stamp)
        self._shown.offer(image, sighting, self._detector.places)
        self._delivery.send(sighting, arrival + self.delay)

    def _expose(self, poses: tuple[MarkerPose, ...]) -> Image:
        renderer, marker = self._renderer, self._settings.marker
        if self.has("frozen") and self._image is not None:
            return self._image
        if self.has("covered"):
            image = renderer.render_darkness()
        elif self.has("lost"):
            image = renderer.render(())
        elif self.has("swapped"):
            other = (marker.ids[0] + 1) % 50  # the smallest dictionaries have 50 markers
            image = renderer.render(poses, diameter=0.6 * marker.diameter, number=other)
        else:
            image = renderer.render(poses)
        if self.has("mirrored"):
            image = image[:, ::-1].copy()
        self._image = image
        return image
