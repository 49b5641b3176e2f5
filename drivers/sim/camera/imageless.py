"""A camera without images, for `--on sim`: the plant's true marker with noise, late."""

import math
from collections.abc import Sequence
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from drivers.marker_camera.device import MarkerCameraDriver
from drivers.marker_camera.link import Event
from drivers.marker_camera.sighting import Sight, Sighting
from drivers.sim.camera.lens import believed_ray
from drivers.sim.camera.ports import CameraBuild, MarkerPort
from drivers.sim.camera.poses import rotation_matrix, twist_of
from drivers.sim.camera.simulated_link import SimulatedLink
from rig.hal import Clock

Position = tuple[float, float, float]
Matrix = tuple[Position, Position, Position]
"""Rows. Numbers, because small arrays take ten times as long."""

_NOISE_BLOCK = 256
"""Frames whose noise is drawn at a time."""


class _ImagelessLink(SimulatedLink):
    """Gives what a detector would, straight from the plant, which is at the time of `poll`."""

    def __init__(self, build: CameraBuild, plant: MarkerPort) -> None:
        super().__init__(build, plant)
        settings, scene, optics = build.settings, build.scene, build.optics
        self._noise = optics.noise
        self._generator = np.random.default_rng(build.seed)
        self._draws: list[list[float]] = []
        calibrated = rotation_matrix(settings.rotation_base_from_camera)
        true = rotation_matrix(scene.rotation_base_from_camera) @ rotation_matrix(
            optics.rotation_error
        )
        self._lens = scene.intrinsics, settings.intrinsics
        self._calibrated, self._to_true = _rows(calibrated), _rows(true.T)
        # What another pose of the camera than it was told makes of an attitude.
        self._turned = _rows(calibrated @ true.T) if np.any(true != calibrated) else None
        self._axis_x = calibrated[:, 0]
        self._camera: Position = settings.position_camera_in_base
        x, y, z = (np.array(scene.position_camera_in_base) + optics.position_error).tolist()
        self._true_camera: Position = x, y, z
        self._due = -inf
        """Before this time there is nothing to do and nothing to tell, s."""
        self._last: Sighting | None = None
        self._identical = 1

    def open(self, now: float) -> None:
        """Begin to see frames."""
        super().open(now)
        self._due = -inf

    def poll(self, now: float) -> Sequence[Event]:
        """Look at the plant if a frame is due, and return what has arrived."""
        if now < self._due:
            return ()
        self.now = now
        start, rate = self._start, self._settings.frame_rate
        if now >= start:
            frame = int((now - start) * rate + 1e-9)
            if frame >= self._frame:
                self._frame = frame + 1
                self._look(frame)
        events = self._delivery.fetch(now)
        self._due = min(self._start + self._frame / rate - 1e-6, self._delivery.next_arrival)
        return events

    def _look(self, frame: int) -> None:
        if self._is_unplugged():
            return
        stamp, arrival = self._delivery.times(self.now)
        if self._delivery.is_dropped() or self.has("stalled"):
            return
        sighting = self._see()._replace(frame=frame, t=stamp)
        self._last = sighting
        self._delivery.send(sighting, arrival + self.delay)

    def _see(self) -> Sighting:
        """Return what the detector would say of this instant, its number and time left open."""
        marker = self._settings.marker
        aruco = marker.kind == "aruco"
        if self.has("frozen") and self._last is not None:
            self._identical += 1
            if self._identical >= self._settings.max_identical:
                return Sighting(0, 0.0, Sight.FROZEN, amount=float(self._identical))
            return self._last
        self._identical = 1
        if self.has("covered"):
            return Sighting(0, 0.0, Sight.COVERED, amount=0.0)
        if self.has("swapped"):
            amount = float(marker.ids[0] + 1) if aruco else 0.6 * marker.diameter
            return Sighting(0, 0.0, Sight.SWAPPED, amount=amount)
        if self.has("mirrored") and aruco:
            return Sighting(0, 0.0, Sight.MIRRORED, amount=float(marker.ids[0]))
        x, y, z = self._plant.marker_position()
        a, b, c = self._camera
        if self.has("lost") or x * (a - x) + y * (b - y) + z * (c - z) <= 0.0:
            return Sighting(0, 0.0, Sight.LOST, amount=0.0)
        if self.has("mirrored"):
            place = np.array((x, y, z))
            place -= 2.0 * ((place - self._camera) @ self._axis_x) * self._axis_x
            x, y, z = place.tolist()
        noise, (u, v, w) = self._noise, self._draw()
        seen = self._end_of_ray((x + noise * u, y + noise * v, z + noise * w))
        if seen is None:
            return Sighting(0, 0.0, Sight.OUTSIDE, amount=0.0)
        twist = nan
        if aruco:
            rotation = self._plant.ring_rotation()
            turned = self._turned
            twist = twist_of(
                rotation if turned is None else (np.array(turned) @ np.array(rotation)).tolist()
            )
        return Sighting(0, 0.0, Sight.SEEN, marker.ids[:1], (seen,), (twist,))

    def _draw(self) -> list[float]:
        """Return three numbers of unit variance."""
        if not self._draws:
            self._draws = self._generator.standard_normal((_NOISE_BLOCK, 3)).tolist()[::-1]
        return self._draws.pop()

    def _end_of_ray(self, place: Position) -> Position | None:
        """Return where the ray to a place ends on the marker's sphere, as calibrated; or None."""
        (x, y, z), (a, b, c) = place, self._true_camera
        x, y, z = _turned(self._to_true, (x - a, y - b, z - c))
        u, v, w = _turned(self._calibrated, (*believed_ray((x / z, y / z), *self._lens), 1.0))
        a, b, c = self._camera
        scale = 1.0 / math.sqrt(u * u + v * v + w * w)
        u, v, w = scale * u, scale * v, scale * w
        radius = self._settings.marker.sphere_radius
        along = -(u * a + v * b + w * c)
        left = along * along - (a * a + b * b + c * c) + radius * radius
        if left < 0.0:
            return None
        distance = along - math.sqrt(left)
        return a + distance * u, b + distance * v, c + distance * w


def _rows(matrix: NDArray[np.float64]) -> Matrix:
    first, second, third = ((x, y, z) for x, y, z in matrix.tolist())
    return first, second, third


def _turned(rows: Matrix, vector: Position) -> Position:
    (a, b, c), (d, e, f), (g, h, i) = rows
    x, y, z = vector
    return a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z


class SimulatedMarkerCamera(MarkerCameraDriver):
    """A marker camera straight on a plant; satisfies `rig.hal.MarkerCamera`.

    Its faults are judged and worded by the production driver, whose class it is. Like the other
    devices without a bus it looks at the plant when the loop takes its readings, so the time of
    a frame is that of a cycle.

    Parameters
    ----------
    build : CameraBuild
        The camera.
    plant : MarkerPort
        The physics.
    clock : Clock
        The rig's.
    required_serial : int, optional
        The serial number that the profile wants of it.
    """

    def __init__(
        self,
        build: CameraBuild,
        plant: MarkerPort,
        clock: Clock,
        *,
        required_serial: int | None = None,
    ) -> None:
        self._breakable = link = _ImagelessLink(build, plant)
        super().__init__(build.name, build.settings, clock, serial=required_serial, link=link)

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` understands."""
        return self._breakable.known_faults

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now; see `CameraFaults`."""
        self._breakable.now = self._clock.now()
        self._breakable.inject(fault, value)
