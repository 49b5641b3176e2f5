"""Finding ArUco markers: their number, centre and corners.

A square marker shows its twist, and its code cannot be read in mirror writing. It costs
precision: four corners know less of the centre than all the pixels of a disc.
"""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from drivers.marker_camera.projection import Point

Image = NDArray[np.uint8]


class Square(NamedTuple):
    """A marker in an image.

    Attributes
    ----------
    number : int
        What its code says.
    corners : tuple of tuple of float
        Top left, top right, bottom right, bottom left as printed, pixels.
    """

    number: int
    corners: tuple[Point, Point, Point, Point]


class SquareFinder:
    """Finds the markers of a dictionary.

    Parameters
    ----------
    dictionary : str
        One of `drivers.marker_camera.settings.DictionaryName`.
    """

    def __init__(self, dictionary: str) -> None:
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        parameters.cornerRefinementWinSize = 4
        parameters.cornerRefinementMaxIterations = 50
        parameters.cornerRefinementMinAccuracy = 0.005
        numbers = cv2.aruco.getPredefinedDictionary(
            int(getattr(cv2.aruco, f"DICT_{dictionary.upper()}"))
        )
        self._detector = cv2.aruco.ArucoDetector(numbers, parameters)

    def find(self, image: Image) -> list[Square]:
        """Return the markers in an image, in the order of their numbers."""
        corners, numbers, _ = self._detector.detectMarkers(np.ascontiguousarray(image))
        # Without a marker OpenCV gives None, whatever its type annotations promise.
        found = [
            Square(int(number), _points(square.reshape(4, 2).tolist()))
            for number, square in zip(np.ravel(numbers) if corners else (), corners, strict=True)
        ]
        return sorted(found, key=lambda square: square.number)

    def find_mirrored(self, image: Image) -> list[int]:
        """Return the numbers of the markers that an image shows in mirror writing."""
        return [square.number for square in self.find(image[:, ::-1])]


def meet_diagonals(corners: Sequence[Point]) -> Point:
    """Return the intersection of a square's diagonals: its centre, in every perspective.

    Parameters
    ----------
    corners : sequence of tuple of float
        The four corners in order, undistorted.

    Raises
    ------
    ValueError
        The diagonals are parallel: the corners are not those of a square.
    """
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = corners
    ux, uy = cx - ax, cy - ay
    vx, vy = dx - bx, dy - by
    cross = ux * vy - uy * vx
    if cross == 0.0:
        raise ValueError(f"The diagonals of {list(corners)} do not meet.")
    s = ((bx - ax) * vy - (by - ay) * vx) / cross
    return ax + s * ux, ay + s * uy


def _points(rows: Sequence[Sequence[float]]) -> tuple[Point, Point, Point, Point]:
    a, b, c, d = ((float(x), float(y)) for x, y in rows)
    return a, b, c, d
