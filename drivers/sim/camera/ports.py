"""What cameras need of a plant, and the time at which a frame arrives."""

import random
from collections.abc import Sequence
from typing import Protocol

from drivers.cameras.settings import MarkerCameraSettings
from drivers.sim.camera.settings import CameraSimulationSettings


class MarkerPort(Protocol):
    """A plant with a marker on it."""

    def marker_position(self) -> Sequence[float]:
        """Return the true centre of the marker in the joint's base frame, m, length 3."""
        ...

    def ring_rotation(self) -> Sequence[Sequence[float]]:
        """Return the true rotation of the ring in the base frame, shape (3, 3), by rows."""
        ...


class Delivery:
    """How long frames travel and which get lost, drawn from a seed.

    Parameters
    ----------
    settings : MarkerCameraSettings
        Whose latency the driver believes in.
    optics : CameraSimulationSettings
        True latency, its spread, losses.
    seed : int
        Of everything random.
    """

    def __init__(
        self, settings: MarkerCameraSettings, optics: CameraSimulationSettings, seed: int
    ) -> None:
        self._believed = settings.latency
        self._latency = settings.latency if optics.latency is None else optics.latency
        self._jitter = optics.latency_jitter
        self._drop_rate = optics.drop_rate
        self._random = random.Random(seed)

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
