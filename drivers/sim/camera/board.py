"""What a camera sees of a chessboard that somebody holds before it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.sim.camera.kernels import cover_squares, expose, trace_rays
from drivers.sim.camera.poses import rotation_matrix
from drivers.sim.camera.settings import CameraSimulationSettings

_DARK = 20.0
"""Level of the board's black squares, counts."""


class BoardRenderer:
    """Renders views of a board through a camera's lens, ray by ray.

    Parameters
    ----------
    settings : MarkerCameraSettings
        The camera as it was built.
    optics : CameraSimulationSettings
        Blur, noise, levels.
    columns, rows : int
        Squares of the board.
    square : float
        Side of one, m.
    seed : int
        Of the noise.
    """

    def __init__(
        self,
        settings: MarkerCameraSettings,
        optics: CameraSimulationSettings,
        columns: int,
        rows: int,
        square: float,
        seed: int,
    ) -> None:
        lens = settings.intrinsics
        self._optics = optics
        self._square = square
        self._focal = np.array([lens.fx, lens.fy])
        self._rays = np.empty((settings.height, settings.width, 2), np.float32)
        trace_rays(
            self._rays,
            self._focal,
            np.array([lens.cx, lens.cy]),
            np.array([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3]),
        )
        # A square sheet, white but for the black squares in its middle.
        side = max(columns, rows) + 2
        self._cells = np.ones((side, side), np.uint8)
        top, left = (side - rows) // 2, (side - columns) // 2
        row, column = np.indices((rows, columns))
        self._cells[top : top + rows, left : left + columns] = (row + column) % 2
        self._generator = np.random.default_rng(seed)

    def render(self, turn: Sequence[float], place: Sequence[float]) -> NDArray[np.uint8]:
        """Return one image.

        Parameters
        ----------
        turn : sequence of float, length 3
            Rotation vector of the board in the camera's frame, rad; none: it faces the camera.
        place : sequence of float, length 3
            Its middle in the camera's frame, m.
        """
        facing = np.diag([1.0, -1.0, -1.0])  # its y is up, its normal looks at the camera
        pose = np.column_stack([rotation_matrix(turn) @ facing, np.asarray(place, float)])
        shape = self._rays.shape[:2]
        cover, light = np.empty(shape, np.float32), np.empty(shape, np.float32)
        blur = float(np.sqrt(self._optics.blur**2 + 1.0 / 12.0))
        cover_squares(
            cover, light, self._rays, pose[None], self._cells, self._square, self._focal, blur
        )
        image = np.empty(shape, np.uint8)
        expose(
            image,
            np.full(shape, self._optics.background, np.float32),
            cover,
            light,
            self._generator.standard_normal(shape, np.float32),
            np.array([_DARK, self._optics.marker]),
            self._optics.read_noise**2,
            self._optics.shot_noise,
        )
        return image
