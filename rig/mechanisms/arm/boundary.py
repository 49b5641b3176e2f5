"""The outline of an arm's reach, as figures and screens draw it."""

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def meridian(reach: float, a1: float, offset: float, points: int) -> "Array":
    """Return the edge of the wrist's reach in a vertical plane, shape (points, 2), m.

    A circle about the shoulder, which `a1` brings ahead of the axis of q1 and a shoulder offset to
    its side; both sides of the axis are outlined.

    Parameters
    ----------
    reach : float
        Shoulder to wrist centre with the elbow stretched, m.
    a1, offset : float
        Of the geometry, m.
    points : int
        An even number.

    Returns
    -------
    ndarray
        Distance from the axis, negative on its other side, and height over the shoulder.
    """
    top = -math.asin(min(max(a1 / reach, -1.0), 1.0))
    lean = np.linspace(top, math.pi - top, points // 2)
    away = np.hypot(np.maximum(a1 + reach * np.sin(lean), 0.0), offset)
    height = reach * np.cos(lean)
    return np.column_stack(
        (np.concatenate((away, -away[::-1])), np.concatenate((height, height[::-1])))
    )
