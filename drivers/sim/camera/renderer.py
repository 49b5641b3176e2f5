"""What a camera above the joint would see.

Only the window round the marker is computed for each frame; the rest comes from a few images of
the scene with noise of their own, drawn once.
"""

import copy
from bisect import bisect_left  # numpy's search copies a row of the image first
from collections.abc import Sequence
from functools import lru_cache
from math import ceil, sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.sim.camera.kernels import cover_disc, cover_squares, expose, trace_rays
from drivers.sim.camera.poses import MarkerPose, rotation_matrix
from drivers.sim.camera.settings import CameraSimulationSettings

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]

_SCENES: Final = 4
"""Images of the scene with different noise."""

_DARK_LEVEL: Final = 1.0
"""What is left of the light under a lens cap, counts."""

_BLACK: Final = 20.0
"""Level of a marker's black cells, counts."""

_MARGIN: Final = 6
"""Of the window round the marker beyond its blur, pixels."""


class MarkerRenderer:
    """Renders the frames of a simulated camera.

    Parameters
    ----------
    settings : MarkerCameraSettings
        Lens, pose and marker as the driver knows them.
    optics : CameraSimulationSettings
        Blur, noise, levels, and by how much the pose is off.
    seed : int
        Of scene and noise.
    """

    def __init__(
        self, settings: MarkerCameraSettings, optics: CameraSimulationSettings, seed: int
    ) -> None:
        self._optics = optics
        self._marker = settings.marker
        lens = settings.intrinsics
        self._focal = np.array([lens.fx, lens.fy])
        self._blur = sqrt(optics.blur**2 + 1.0 / 12.0)  # a pixel is one wide
        turn = rotation_matrix(settings.rotation_base_from_camera)
        self._camera_from_base = (turn @ rotation_matrix(optics.rotation_error)).T
        self._camera = np.array(settings.position_camera_in_base) + optics.position_error
        self._rays, self._scene, self._scenes, generator = _make_backdrop(settings, optics, seed)
        self._generator = copy.deepcopy(generator)
        self._darkness: list[Image] = []
        self._frames = 0
        dark = self._marker.kind == "blob" and self._marker.polarity == "dark"
        self._levels = np.array([_BLACK, _BLACK if dark else optics.marker])

    def render(
        self,
        poses: Sequence[MarkerPose],
        *,
        diameter: float | None = None,
        number: int | None = None,
    ) -> Image:
        """Return one frame.

        Parameters
        ----------
        poses : sequence of MarkerPose
            At instants spread over the exposure; none: the marker is out of sight.
        diameter : float, optional
            Of another disc than that of the settings, m.
        number : int, optional
            Of another ArUco marker than the first of the settings.

        Returns
        -------
        ndarray of uint8, shape (height, width)
        """
        self._frames += 1
        image = self._scenes[self._frames % _SCENES].copy()
        if not poses:
            return image
        placed = np.stack([self._to_camera(pose) for pose in poses])
        squares = self._marker.kind == "aruco"
        marker = self._marker
        disc = marker.diameter if diameter is None else diameter
        cells = marker_cells(marker.dictionary, marker.ids[0] if number is None else number)
        cell = marker.side / (cells.shape[0] - 2)
        window = self._window(placed, 0.5 * (cells.shape[0] * cell if squares else disc))
        if window is None:
            return image
        rays = self._rays[window]
        cover = np.empty(rays.shape[:2], np.float32)
        light = cover
        if squares:
            light = np.empty_like(cover)
            cover_squares(cover, light, rays, placed, cells, cell, self._focal, self._blur)
        else:
            cover_disc(cover, rays, placed, 0.5 * disc, self._focal, self._blur)
        expose(
            image[window],
            self._scene[window],
            cover,
            light,
            self._generator.standard_normal(cover.shape, np.float32),
            self._levels,
            self._optics.read_noise**2,
            self._optics.shot_noise,
        )
        return image

    def render_darkness(self) -> Image:
        """Return a frame with the lens covered."""
        if not self._darkness:
            night = np.full_like(self._scene, _DARK_LEVEL)
            self._darkness = [
                _with_noise(night, self._optics, self._generator) for _ in range(_SCENES)
            ]
        self._frames += 1
        return self._darkness[self._frames % _SCENES].copy()

    def _to_camera(self, pose: MarkerPose) -> Floats:
        """Return a marker's axes and centre as columns in the camera's frame, shape (3, 4)."""
        centre = np.asarray(pose.position, float) - self._camera
        columns = np.column_stack([np.asarray(pose.rotation, float), centre])
        return np.asarray(self._camera_from_base @ columns)

    def _window(self, placed: Floats, reach: float) -> tuple[slice, slice] | None:
        """Return the rows and columns that may show the marker, None if it is out of view.

        The rays of the image itself are searched for the directions of the marker's corners
        (`reach` from its centre along both axes), so that no forward model of the lens is needed.
        """
        square = reach * np.array([[1, 1, -1, -1], [1, -1, 1, -1]])
        corners = placed[:, :, :2] @ square + placed[:, :, 3:]
        depth = corners[:, 2]
        if (depth <= 0.0).any():
            return None
        x, y = corners[:, 0] / depth, corners[:, 1] / depth
        rows, columns = self._scene.shape
        row, column = rows // 2, columns // 2
        margin = ceil(5.0 * self._blur) + _MARGIN
        ends = []
        for goal_x, goal_y in ((x.min(), y.min()), (x.max(), y.max())):
            for _ in range(4):  # a column's x hardly depends on its row, and the other way round
                column = bisect_left(self._rays[min(row, rows - 1), :, 0], goal_x)
                row = bisect_left(self._rays[:, min(column, columns - 1), 1], goal_y)
            ends.append((row, column))
        (top, left), (bottom, right) = ends
        if bottom == 0 or right == 0 or top == rows or left == columns:
            return None
        return (
            slice(max(top - margin, 0), bottom + margin),
            slice(max(left - margin, 0), right + margin),
        )


class _Backdrop(NamedTuple):
    """The view of a camera without its marker; nobody writes to it.

    Attributes
    ----------
    rays : ndarray, shape (height, width, 2)
        Direction of each pixel's ray, (x/z, y/z).
    scene : ndarray, shape (height, width)
        Without noise, counts.
    scenes : list of ndarray
        With different noise.
    generator : numpy.random.Generator
        As it is after them.
    """

    rays: NDArray[np.float32]
    scene: NDArray[np.float32]
    scenes: list[Image]
    generator: np.random.Generator


@lru_cache(maxsize=2)  # some 20 MB each, and half a second: most runs of a process share a camera
def _make_backdrop(
    settings: MarkerCameraSettings, optics: CameraSimulationSettings, seed: int
) -> _Backdrop:
    generator = np.random.default_rng(seed)
    lens = settings.intrinsics
    shape = (settings.height, settings.width)
    rays = np.empty((*shape, 2), np.float32)
    trace_rays(
        rays,
        np.array([lens.fx, lens.fy]),
        np.array([lens.cx, lens.cy]),
        np.array([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3]),
    )
    bright = settings.marker.kind == "aruco" or settings.marker.polarity == "dark"
    scene = _make_scene(shape, optics, generator, bright=bright)
    scenes = [_with_noise(scene, optics, generator) for _ in range(_SCENES)]
    return _Backdrop(rays, scene, scenes, generator)


def _make_scene(
    shape: tuple[int, int],
    optics: CameraSimulationSettings,
    generator: np.random.Generator,
    *,
    bright: bool,
) -> NDArray[np.float32]:
    """Return the scene without marker and noise, counts."""
    y, x = np.meshgrid(*(np.linspace(-1.0, 1.0, count) for count in shape), indexing="ij")
    light = optics.background * (1.0 - optics.vignetting * 0.5 * (x * x + y * y))
    for _ in range(6):  # a few soft waves: nothing in a lab is evenly lit
        fx, fy, phase = generator.uniform([-6, -6, 0], [6, 6, 6.3])
        light += optics.texture / sqrt(3.0) * np.sin(fx * x + fy * y + phase)
    if bright:  # dark markers, and squares, are seen before a light scene
        light += 0.5 * optics.marker
    scene: NDArray[np.float32] = np.clip(light, 0.0, 255.0).astype(np.float32)
    return scene


def _with_noise(
    scene: NDArray[np.float32], optics: CameraSimulationSettings, generator: np.random.Generator
) -> Image:
    spread = np.sqrt(optics.read_noise**2 + optics.shot_noise * scene)
    noisy = scene + spread * generator.standard_normal(scene.shape, np.float32)
    image: Image = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    return image


@lru_cache(maxsize=8)
def marker_cells(dictionary: str, number: int) -> Image:
    """Return the cells of an ArUco marker with one white cell all round, 0 black and 1 white."""
    import cv2

    known = cv2.aruco.getPredefinedDictionary(int(getattr(cv2.aruco, f"DICT_{dictionary.upper()}")))
    side = known.markerSize + 2
    printed = cv2.aruco.generateImageMarker(known, number, side)
    return np.pad((printed > 127).astype(np.uint8), 1, constant_values=1)
