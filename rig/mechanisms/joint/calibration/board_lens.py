"""A lens from views of a chessboard, by Zhang's method with OpenCV, and how well it is known.

References
----------
Z. Zhang, "A flexible new technique for camera calibration", IEEE Transactions on Pattern Analysis
and Machine Intelligence 22(11), 2000.
"""

import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple, Protocol

import numpy as np

from rig.calibration.arrays import Array
from rig.calibration.recording import CalibrationRefused
from rig.hal.image_files import check_video, read_grey
from rig.mechanisms.joint.calibration.board_lens_fit import LENS, fit_weighted

LEAST_VIEWS: Final = 6
"""So many views have to show the whole board."""

_LEAST_TILT: Final = 0.25
"""The views' boards have to be turned so far against each other, rad: else focal length and
distance cannot be told apart."""

_LEAST_SPREAD: Final = 0.5
"""Of the image's width and height that the corners of all views have to span."""

_FROM_VIDEO: Final = 40
"""So many frames are taken from a video, spread over it."""


class Intrinsics(Protocol):
    """A lens as a camera's settings have it: pinhole with distortion after Brown and Conrady.

    Parameters
    ----------
    fx, fy, cx, cy : float
        Focal lengths and principal point, pixels.
    k1, k2, p1, p2, k3 : float
        Distortion.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    k1: float
    k2: float
    p1: float
    p2: float
    k3: float


class Board(NamedTuple):
    """A chessboard.

    Parameters
    ----------
    columns, rows : int
        Squares; one odd and one even, so that nobody can hold it upside down.
    square : float
        Side of a square, m.
    """

    columns: int = 10
    rows: int = 7
    square: float = 8e-3

    @classmethod
    def parse(cls, text: str) -> "Board":
        """Read ``10x7x8mm``: columns, rows and the side of a square.

        Raises
        ------
        CalibrationRefused
            It is no board that can be used.
        """
        from rig.config.quantities import UnitError, parse_quantity

        try:
            columns, rows, square = text.split("x")
            board = cls(int(columns), int(rows), parse_quantity(square.strip(), "m"))
        except (ValueError, UnitError) as error:
            raise CalibrationRefused(
                f"{text!r} is no board: say columns, rows and side, as in 10x7x8mm ({error})"
            ) from error
        if min(board.columns, board.rows) < 4 or (board.columns + board.rows) % 2 == 0:
            raise CalibrationRefused(
                f"a board of {board.columns} x {board.rows} squares cannot be used: at least 4 "
                "each way, and one number odd and one even"
            )
        if not board.square > 0.0:
            raise CalibrationRefused("the squares of a board have a side")
        return board

    @property
    def corners(self) -> Array:
        """Where squares meet, in the board's plane, m, shape (n, 3)."""
        grid = np.zeros(((self.columns - 1) * (self.rows - 1), 3))
        grid[:, :2] = np.mgrid[: self.columns - 1, : self.rows - 1].T.reshape(-1, 2)
        return grid * self.square


class Views(NamedTuple):
    """The corners of a board in several images.

    Parameters
    ----------
    board : Board
        The board.
    paths : tuple of Path
        The files that they are from.
    size : tuple of int
        Width and height of the images, pixels.
    names : tuple of str
        Of the images that show the whole board.
    corners : ndarray, shape (views, n, 2)
        Pixels.
    seen : int
        Images that were looked at.
    """

    board: Board
    paths: tuple[Path, ...]
    size: tuple[int, int]
    names: tuple[str, ...]
    corners: Array
    seen: int

    @property
    def samples(self) -> int:
        """Corners of all views."""
        return self.corners[..., 0].size

    def sha256(self) -> str:
        """Return the digest of the files, in hexadecimal digits."""
        digest = hashlib.sha256()
        for path in self.paths:
            digest.update(path.read_bytes())
        return digest.hexdigest()


class FittedLens(NamedTuple):
    """A lens with its covariance.

    Parameters
    ----------
    values : dict of str to float
        fx, fy, cx, cy, k1, k2.
    stds : dict of str to float
        Their standard deviations.
    residuals : ndarray, shape (views, n, 2)
        Measured less projected corners, pixels.
    """

    values: dict[str, float]
    stds: dict[str, float]
    residuals: Array


def read_views(source: Path, board: Board) -> Views:
    """Look for a board in the images of a folder, or in the frames of a video.

    Raises
    ------
    CalibrationRefused
        There are no images, they differ in size, or too few of them show the board.
    """
    import cv2

    paths, images = _images(source)
    shape = (board.columns - 1, board.rows - 1)
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE
    names, found, sizes = [], [], set()
    seen = 0
    for name, image in images:
        seen += 1
        sizes.add(image.shape[1::-1])
        there, corners = cv2.findChessboardCornersSB(image, shape, flags=flags)
        if there:
            names.append(name)
            found.append(np.asarray(corners, float).reshape(-1, 2))
    if not seen:
        raise CalibrationRefused(f"{source} holds no image: show the camera a board, and record it")
    if len(sizes) > 1:
        raise CalibrationRefused(f"the images of {source} are not all of one size: {sorted(sizes)}")
    if len(found) < LEAST_VIEWS:
        raise CalibrationRefused(
            f"{len(found)} of {seen} images show a board of {board.columns} x {board.rows} "
            f"squares, at least {LEAST_VIEWS} are needed: is it the right board, whole, in focus?"
        )
    (size,) = sizes
    return Views(board, tuple(paths), size, tuple(names), np.array(found), seen)


def fit_lens(views: Views, guess: Intrinsics) -> FittedLens:
    """Return the lens that projects a board's corners to where they were seen.

    Raises
    ------
    CalibrationRefused
        The views do not determine it: the board always faced the camera, or kept to one place.
    """
    import cv2

    width, height = views.size
    spread = np.ptp(views.corners.reshape(-1, 2), axis=0) / (width, height)
    if spread.min() < _LEAST_SPREAD:
        raise CalibrationRefused(
            f"the boards span {100 * spread[0]:.0f} % of the width and {100 * spread[1]:.0f} % of "
            f"the height, at least {100 * _LEAST_SPREAD:.0f} % are needed: show it in the corners"
        )
    grid = views.board.corners.astype(np.float32)
    camera = np.array([[guess.fx, 0.0, guess.cx], [0.0, guess.fy, guess.cy], [0.0, 0.0, 1.0]])
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3
    corners = [each.astype(np.float32) for each in views.corners]
    _, matrix, bend, turns, places = cv2.calibrateCamera(
        [grid] * len(corners), corners, views.size, camera, np.zeros(5), flags=flags
    )
    normals = np.array([cv2.Rodrigues(turn)[0][:, 2] for turn in turns])
    if np.arccos(np.clip((normals @ normals.T).min(), -1.0, 1.0)) < _LEAST_TILT:
        raise CalibrationRefused(
            "the board faced the camera alike in every view: focal length and distance cannot be "
            f"told apart; tilt it by {np.degrees(_LEAST_TILT):.0f} deg and more, to all sides"
        )
    first = np.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *bend.ravel()[:2]])
    poses = np.hstack([np.array(each, float).reshape(-1, 3) for each in (turns, places)])
    found = fit_weighted(views.board.corners, views.corners, first, poses)
    return FittedLens(
        dict(zip(LENS, found.values.tolist(), strict=True)),
        dict(zip(LENS, found.stds.tolist(), strict=True)),
        found.residuals,
    )


def project(views: Views, lens: Intrinsics) -> Array:
    """Return where a lens has the corners, each board where that lens sees it best, pixels."""
    import cv2

    matrix = np.array([[lens.fx, 0.0, lens.cx], [0.0, lens.fy, lens.cy], [0.0, 0.0, 1.0]])
    bend = np.array([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3])
    rows, grid = [], views.board.corners
    for corners in views.corners:
        _, turn, place = cv2.solvePnP(grid, corners, matrix, bend)
        rows.append(cv2.projectPoints(grid, turn, place, matrix, bend)[0].reshape(-1, 2))
    return np.array(rows)


def _images(source: Path) -> tuple[Sequence[Path], Iterator[tuple[str, Any]]]:
    """Return the files and the grey images of a folder or a video."""
    if source.is_dir():
        paths = sorted(p for p in source.iterdir() if p.is_file() and _is_image(p))
        read = ((p.name, read_grey(p)) for p in paths)
        return paths, ((name, image) for name, image in read if image is not None)
    check_video(source)
    return [source], _frames(source)


def _is_image(path: Path) -> bool:
    import cv2

    return bool(cv2.haveImageReader(str(path)))


def _frames(source: Path) -> Iterator[tuple[str, Any]]:
    import cv2

    video = cv2.VideoCapture(str(source))
    count = int(video.get(cv2.CAP_PROP_FRAME_COUNT))
    step = max(count // _FROM_VIDEO, 1)
    try:
        for number in range(max(count, 1)):
            there, image = video.read()
            if not there:
                return
            if number % step == 0:
                yield f"frame {number}", cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    finally:
        video.release()
