"""Poses of a marker, and cameras small enough for quick tests."""

import math

import numpy as np

from drivers.marker_camera.settings import IntrinsicsSettings, MarkerCameraSettings, MarkerSettings
from drivers.sim.camera.poses import MarkerPose
from drivers.sim.camera.renderer import MarkerRenderer
from drivers.sim.camera.settings import CameraSimulationSettings

H = 52.628e-3

QUIET = CameraSimulationSettings(read_noise=0.0, shot_noise=0.0, texture=0.0, vignetting=0.0)
BENT = IntrinsicsSettings(
    fx=3333.0, fy=3320.0, cx=258.0, cy=251.0, k1=-0.12, k2=0.1, p1=4e-4, p2=-3e-4, k3=0.05
)
STRAIGHT = IntrinsicsSettings(cx=255.5, cy=255.5)


def small(intrinsics=STRAIGHT, size=512, **marker):
    """A camera that sees tilts of up to 25 degrees."""
    return MarkerCameraSettings(
        width=size, height=size, intrinsics=intrinsics, marker=MarkerSettings(**marker)
    )


def turn(axis, angle):
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k


def pose(tilt, azimuth=0.0, twist=0.0, h=H):
    """A marker tilted towards an azimuth, without twist unless some is given; rad."""
    swing = turn((-math.sin(azimuth), math.cos(azimuth), 0.0), tilt)
    rotation = swing @ turn((0, 0, 1), twist)
    return MarkerPose(h * rotation[:, 2], rotation)


def random_poses(count, largest, seed=0, twist=0.0):
    generator = np.random.default_rng(seed)
    return [
        pose(
            largest * math.sqrt(generator.uniform()),
            generator.uniform(0, 2 * math.pi),
            generator.uniform(-twist, twist),
        )
        for _ in range(count)
    ]


def render_all(settings, poses, optics=QUIET, seed=1):
    renderer = MarkerRenderer(settings, optics, seed)
    return [renderer.render([item]) for item in poses]


def rms(errors):
    return float(np.sqrt(np.mean(np.sum(np.atleast_2d(errors) ** 2, axis=-1))))
