"""Finding a disc in an image: Otsu's threshold, the largest blob, its grey-weighted centroid.

The centroid of the threshold's mask alone moves in steps with the pixels; weighting every pixel
with what it has above the background brings the noise below 0.02 pixels.

References
----------
Otsu 1979, A threshold selection method from gray-level histograms, eqs. (12) to (18).
"""

from typing import Any, Final, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

cv2.setNumThreads(1)  # a second core helps little, and a pool of threads does not survive a fork

Image = NDArray[np.uint8]

_RIM: Final = 3
"""How far the blur of the edge reaches beyond the mask, pixels."""

_RING: Final = 3
"""Width of the ring beyond the rim that tells the background, pixels."""

_SPREAD: Final = 1.0
"""How far pixels must spread both ways for a plane, product of their rms, pixels²."""

_KERNEL: Final = np.ones((2 * _RIM + 1, 2 * _RIM + 1), np.uint8)
_LEVELS: Final = np.arange(256, dtype=float)


class Split(NamedTuple):
    """An image in two classes.

    Attributes
    ----------
    threshold : int
        Greatest level of the darker class, counts.
    contrast : float
        Difference of the means of the two classes, counts.
    """

    threshold: int
    contrast: float


class Blob(NamedTuple):
    """A connected region above the threshold.

    Attributes
    ----------
    x, y : float
        Grey-weighted centroid, pixels of the image that was searched.
    area : float
        Number of its pixels.
    cut : bool
        It touches the border of what was searched.
    """

    x: float
    y: float
    area: float
    cut: bool


def compute_histogram(image: Image) -> NDArray[np.float64]:
    """Return how many pixels have each of the 256 levels, shape (256,)."""
    return cv2.calcHist([image], [0], None, [256], [0, 256]).ravel().astype(float)


def split_levels(histogram: NDArray[np.float64]) -> Split:
    """Return Otsu's threshold: the two classes' means lie furthest apart for their spread."""
    below = np.cumsum(histogram)
    first = np.cumsum(histogram * _LEVELS)
    total, mean = below[-1], first[-1]
    above = total - below
    both = (below > 0.0) & (above > 0.0)
    if not both.any():
        return Split(int(np.argmax(histogram)), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        gap = np.where(both, (mean - first) / above - first / below, 0.0)
    # Levels that no pixel has give a plateau: its middle is furthest from both classes.
    between = below * above * gap * gap
    best = np.flatnonzero(between >= between.max() * (1.0 - 1e-12))
    threshold = int(best[len(best) // 2])
    return Split(threshold, float(gap[threshold]))


def find_largest_blob(image: Image, threshold: int) -> Blob | None:
    """Return the largest region brighter than a threshold, or None if there is none.

    Parameters
    ----------
    image : ndarray of uint8, shape (rows, columns)
        A region of interest; the disc is bright.
    threshold : int
        Greatest level that is background, counts.
    """
    mask = cv2.threshold(image, threshold, 255, cv2.THRESH_BINARY)[1]
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    if count < 2:
        return None
    number = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    left, top, width, height, area = (int(value) for value in stats[number])
    rows, columns = image.shape
    cut = left == 0 or top == 0 or left + width == columns or top + height == rows
    margin = _RIM + _RING
    x0, y0 = max(left - margin, 0), max(top - margin, 0)
    window = slice(y0, top + height + margin), slice(x0, left + width + margin)
    x, y = _weigh(image[window], labels[window] == number)
    return Blob(x0 + x, y0 + y, float(area), cut)


def _weigh(image: Image, mask: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the centroid of a disc, pixels: every pixel counts by how much the disc covers it.

    The surroundings show how bright a pixel would be without the disc, the disc's inside how
    bright with it alone, each as a plane: light that falls off sideways would otherwise draw the
    centroid, by 0.03 pixels for a slope of 0.02 counts per pixel.
    """
    part = mask.astype(np.uint8)
    reached = cv2.dilate(part, _KERNEL)
    levels = image.astype(np.float32)
    inside = cv2.erode(part, _KERNEL)
    alone = _fit_plane(levels, inside if inside.any() else part)
    without = _fit_plane(levels, 1 - reached) if not reached.all() else np.zeros_like(levels)
    # In noise that is no disc, nothing may divide by nothing.
    cover = (levels - without) / np.maximum(alone - without, 1.0) * reached
    moments: dict[str, Any] = cv2.moments(cover)
    if moments["m00"] < 0.5:
        moments = cv2.moments(part, binaryImage=True)
    return moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]


def _fit_plane(levels: NDArray[np.float32], mask: NDArray[Any]) -> NDArray[np.float32]:
    """Return the plane through the levels of some pixels; their mean if they lie on a line."""
    rows, columns = np.nonzero(mask)
    values = levels[rows, columns]
    middle_row, middle_column = rows.mean(), columns.mean()
    basis = np.ones((3, len(rows)), np.float32)
    basis[1] = rows - middle_row
    basis[2] = columns - middle_column
    products = (basis @ basis.T).astype(float)
    if products[1, 1] * products[2, 2] - products[1, 2] ** 2 < (_SPREAD * len(rows)) ** 2:
        return np.full_like(levels, values.mean())
    level, down, along = np.linalg.solve(products, basis @ values)
    column = level + down * (np.arange(levels.shape[0]) - middle_row)
    row = along * (np.arange(levels.shape[1]) - middle_column)
    plane: NDArray[np.float32] = np.add.outer(column, row).astype(np.float32)
    return plane
