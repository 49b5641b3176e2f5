"""What cameras need of a plant, what they are, and how their frames travel."""

import random
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Protocol

from drivers.marker_camera.link import Event
from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.sim.camera.settings import CameraSimulationSettings


class MarkerPort(Protocol):
    """A plant with a marker on it. Inherit it: what has a default need not be written."""

    @property
    def camera(self) -> CameraSimulationSettings:
        """What the camera that watches the marker is really like."""
        return CameraSimulationSettings()

    def marker_position(self) -> Sequence[float]:
        """Return the true centre of the marker in the joint's base frame, m, length 3."""

    def ring_rotation(self) -> Sequence[Sequence[float]]:
        """Return the true rotation of the ring in the base frame, shape (3, 3), by rows."""


@dataclass(frozen=True, slots=True)
class CameraBuild:
    """One simulated camera, and what is true of it.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : MarkerCameraSettings
        As the driver has them: rate, latency, marker, limits.
    scene : MarkerCameraSettings
        As the camera was built and mounted: lens, pose, latency.
    optics : CameraSimulationSettings
        What the camera is really like beside that.
    seed : int
        Of scene, noise, losses.
    serial : str or None
        What it reports as its serial number.
    """

    name: str
    settings: MarkerCameraSettings
    scene: MarkerCameraSettings
    optics: CameraSimulationSettings
    seed: int
    serial: str | None

    @property
    def instants(self) -> tuple[float, ...]:
        """When in an exposure the plant is looked at, s from its start."""
        step = self.settings.exposure
        count = self.optics.sub_exposures
        return tuple(step * (k + 0.5) / count for k in range(count))


class Delivery:
    """Frames on their way to the driver: how long they take and which get lost, from a seed.

    Parameters
    ----------
    build : CameraBuild
        The latency that the driver believes in and the true one, losses, seed.
    """

    def __init__(self, build: CameraBuild) -> None:
        optics = build.optics
        self._believed = build.settings.latency
        self._latency = build.scene.latency if optics.latency is None else optics.latency
        self._jitter = optics.latency_jitter
        self._drop_rate = optics.drop_rate
        self._random = random.Random(build.seed)
        self._under_way: deque[tuple[float, Event]] = deque()

    def is_dropped(self) -> bool:
        """Return whether the next frame is lost."""
        return self._random.random() < self._drop_rate

    def times(self, middle: float) -> tuple[float, float]:
        """Return the time stamp and the arrival of a frame, s.

        Parameters
        ----------
        middle : float
            True middle of its exposure, s.
        """
        took = max(self._latency + self._random.gauss(0.0, self._jitter), 0.0)
        # The driver subtracts the latency that it was told from when the frame came.
        return middle + took - self._believed, middle + took

    def send(self, event: Event, arrival: float) -> None:
        """Have an event arrive at a time (s), but not before what was sent earlier."""
        if self._under_way:
            arrival = max(arrival, self._under_way[-1][0])
        self._under_way.append((arrival, event))

    @property
    def next_arrival(self) -> float:
        """When the next event arrives, s; infinite if none is under way."""
        return self._under_way[0][0] if self._under_way else inf

    def fetch(self, now: float) -> Sequence[Event]:
        """Return what has arrived by `now` (s) and was not fetched yet."""
        events: list[Event] = []
        while self._under_way and self._under_way[0][0] <= now:
            events.append(self._under_way.popleft()[1])
        return events

    def lose(self) -> None:
        """Lose everything that is under way."""
        self._under_way.clear()
