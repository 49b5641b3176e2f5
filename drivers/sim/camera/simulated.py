"""A camera without images, for `--on sim`: the plant's true marker with noise, late."""

import math
from collections.abc import Sequence
from math import inf, nan

import numpy as np

from drivers.cameras.link import Event, Ready
from drivers.cameras.marker_camera import MarkerCameraDriver
from drivers.cameras.settings import MarkerCameraSettings
from drivers.cameras.sighting import Sight, Sighting
from drivers.sim.camera.faults import UNPLUGGED, CameraFaults
from drivers.sim.camera.lens import believed_ray
from drivers.sim.camera.ports import Delivery, MarkerPort
from drivers.sim.camera.poses import Floats, rotation_matrix, twist_of
from drivers.sim.camera.settings import CameraSimulationSettings
from rig.hal import Clock

Position = tuple[float, float, float]


class _ImagelessLink:
    """Gives what a detector would, straight from the plant, which is at the time of `poll`."""

    def __init__(
        self,
        settings: MarkerCameraSettings,
        scene: MarkerCameraSettings,
        optics: CameraSimulationSettings,
        plant: MarkerPort,
        seed: int,
        faults: CameraFaults,
        serial: str | None,
    ) -> None:
        self._settings = settings
        self._plant = plant
        self._faults = faults
        self._serial = serial
        self._noise = optics.noise
        self._generator = np.random.default_rng(seed)
        self._delivery = Delivery(settings.latency, scene.latency, optics, seed)
        self._calibrated = rotation_matrix(settings.rotation_base_from_camera)
        self._lens = scene.intrinsics, settings.intrinsics
        self._true = rotation_matrix(scene.rotation_base_from_camera) @ rotation_matrix(
            optics.rotation_error
        )
        self._axis_x = self._calibrated[:, 0]
        self._camera = np.array(settings.position_camera_in_base)
        self._turned = bool(np.any(self._true != self._calibrated))
        self._true_camera = np.array(scene.position_camera_in_base) + optics.position_error
        self._start = inf
        self._frame = -1
        self._last: Sighting | None = None
        self._identical = 1

    def open(self, now: float) -> None:
        """Begin to see frames."""
        self.close()
        if self._faults.has("unplugged"):
            self._delivery.send(UNPLUGGED, now)
            return
        self._start = now
        self._delivery.send(Ready(self._serial), now)

    def poll(self, now: float) -> Sequence[Event]:
        """Look at the plant if a frame is due, and return what has arrived."""
        if now >= self._start:
            frame = int((now - self._start) * self._settings.frame_rate + 1e-9)
            if frame > self._frame:
                self._frame = frame
                self._look(frame, now)
        return self._delivery.fetch(now)

    def close(self) -> None:
        """Stop. Idempotent."""
        self._start = inf
        self._frame = -1
        self._delivery.lose()

    def _look(self, frame: int, now: float) -> None:
        faults = self._faults
        if faults.has("unplugged"):
            self.close()
            self._delivery.send(UNPLUGGED, now)
            return
        stamp, arrival = self._delivery.times(now)
        if self._delivery.is_dropped() or faults.has("stalled"):
            return
        sighting = self._see()._replace(frame=frame, t=stamp)
        self._last = sighting
        self._delivery.send(sighting, arrival + faults.delay)

    def _see(self) -> Sighting:
        """Return what the detector would say of this instant, its number and time left open."""
        faults, marker = self._faults, self._settings.marker
        aruco = marker.kind == "aruco"
        if faults.has("frozen") and self._last is not None:
            self._identical += 1
            if self._identical >= self._settings.max_identical:
                return Sighting(0, 0.0, Sight.FROZEN, amount=float(self._identical))
            return self._last
        self._identical = 1
        if faults.has("covered"):
            return Sighting(0, 0.0, Sight.COVERED, amount=0.0)
        if faults.has("swapped"):
            amount = float(marker.ids[0] + 1) if aruco else 0.6 * marker.diameter
            return Sighting(0, 0.0, Sight.SWAPPED, amount=amount)
        if faults.has("mirrored") and aruco:
            return Sighting(0, 0.0, Sight.MIRRORED, amount=float(marker.ids[0]))
        place = np.array(self._plant.marker_position(), float)
        if faults.has("lost") or place @ (self._camera - place) <= 0.0:
            return Sighting(0, 0.0, Sight.LOST, amount=0.0)
        if faults.has("mirrored"):
            place -= 2.0 * ((place - self._camera) @ self._axis_x) * self._axis_x
        place += self._noise * self._generator.standard_normal(3)
        seen = self._end_of_ray(place)
        if seen is None:
            return Sighting(0, 0.0, Sight.OUTSIDE, amount=0.0)
        x, y, z = seen
        twist = twist_of(self._plant.ring_rotation()) if aruco else nan
        if aruco and self._turned:
            believed = self._calibrated @ self._true.T @ np.array(self._plant.ring_rotation())
            twist = twist_of(believed.tolist())
        return Sighting(0, 0.0, Sight.SEEN, marker.ids[:1], ((x, y, z),), (twist,))

    def _end_of_ray(self, place: Floats) -> Position | None:
        """Return where the ray to a place ends on the marker's sphere, as calibrated; or None."""
        x, y, z = (self._true.T @ (place - self._true_camera)).tolist()
        ray = self._calibrated @ np.array((*believed_ray((x / z, y / z), *self._lens), 1.0))
        ray /= math.sqrt(float(ray @ ray))
        radius = self._settings.marker.sphere_radius
        along = -float(ray @ self._camera)
        left = along * along - float(self._camera @ self._camera) + radius * radius
        if left < 0.0:
            return None
        x, y, z = (self._camera + (along - math.sqrt(left)) * ray).tolist()
        return x, y, z


class SimulatedMarkerCamera(MarkerCameraDriver):
    """A marker camera straight on a plant; satisfies `rig.hal.MarkerCamera`.

    Its faults are judged and worded by the production driver, whose class it is. Like the other
    devices without a bus it looks at the plant when the loop takes its readings, so the time of
    a frame is that of a cycle.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : MarkerCameraSettings
        Rate, latency, marker, limits.
    scene : MarkerCameraSettings
        As the camera was built and mounted: lens, pose, latency.
    optics : CameraSimulationSettings
        Losses, noise, errors beside that.
    plant : MarkerPort
        The physics.
    clock : Clock
        The rig's.
    seed : int
        Of noise and losses.
    serial : int, optional
        The serial number, which the simulated camera has.
    """

    def __init__(
        self,
        name: str,
        settings: MarkerCameraSettings,
        scene: MarkerCameraSettings,
        optics: CameraSimulationSettings,
        plant: MarkerPort,
        clock: Clock,
        seed: int,
        *,
        serial: int | None = None,
    ) -> None:
        self._faults = CameraFaults(name)
        own = settings.calibrated_serial if serial is None else str(serial)
        link = _ImagelessLink(settings, scene, optics, plant, seed, self._faults, own)
        super().__init__(name, settings, clock, serial=serial, link=link)

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` understands."""
        return self._faults.known

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now; see `CameraFaults`."""
        self._faults.now = self._clock.now()
        self._faults.inject(fault, value)

    def _take(self) -> None:
        self._faults.now = self._clock.now()
        super()._take()
