"""How a simulated camera differs from its profile: lens, latency and pose, as a seed draws them."""

import zlib
from dataclasses import replace

import numpy as np

from drivers.marker_camera.settings import IntrinsicsSettings, MarkerCameraSettings
from drivers.sim.camera.settings import CameraSimulationSettings
from drivers.sim.perturbation import Bounds, draw


def built(settings: MarkerCameraSettings, bounds: Bounds, seed: int) -> MarkerCameraSettings:
    """Return a camera's settings before any calibration with its lens and latency as drawn."""
    focal, bend, late, right, down = _draw(bounds, seed)
    lens = settings.intrinsics
    return replace(
        settings,
        intrinsics=IntrinsicsSettings(
            lens.fx * (1.0 + focal), lens.fy * (1.0 + focal), lens.cx + right, lens.cy + down,
            lens.k1 + bend, lens.k2, lens.p1, lens.p2, lens.k3,
        ),
        latency=settings.latency + late,
    )  # fmt: skip


def mounted(
    optics: CameraSimulationSettings, bounds: Bounds, seed: int
) -> CameraSimulationSettings:
    """Return what a simulated camera is like with the errors of its pose as drawn."""
    draws = draw(bounds, seed)
    return replace(
        optics,
        position_error=_sum(optics.position_error, draws.camera_position),
        rotation_error=_sum(optics.rotation_error, draws.camera_angle),
    )


def _draw(bounds: Bounds, seed: int) -> tuple[float, float, float, float, float]:
    """Return shares of the focal length, k1, s of latency, and pixels of the principal point."""
    shares = np.random.default_rng([seed, zlib.crc32(b"camera")]).uniform(-1.0, 1.0, 5)
    focal, bend, late, right, down = shares.tolist()
    return (
        bounds["camera_focal"] * focal,
        bounds["camera_distortion"] * bend,
        bounds["camera_latency"] * late,
        bounds["camera_centre"] * right,
        bounds["camera_centre"] * down,
    )


def _sum(
    one: tuple[float, float, float], other: tuple[float, float, float]
) -> tuple[float, float, float]:
    return one[0] + other[0], one[1] + other[1], one[2] + other[2]
