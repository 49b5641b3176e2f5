"""Long signals on few pixels, without losing a peak."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

POINTS = 3000
"""Greatest number of points of a drawn line: more than any print resolves at 170 mm."""


def envelope(
    t: "NDArray[np.float64]", x: "NDArray[np.float64]", points: int = POINTS
) -> "tuple[NDArray[np.float64], NDArray[np.float64]]":
    """Keep the smallest and greatest sample of each stretch, in their order.

    Taking every k-th sample would drop single-sample peaks and fold fast oscillations into
    slow ones; this shows both as a reader of the whole signal would see them.

    Parameters
    ----------
    t, x : ndarray
        Shape (n,).
    points : int
        Greatest number of points to return, at least 2.

    Returns
    -------
    t, x : ndarray
        Shape (m,), m <= max(points, 4); the input itself if it is short enough.
    """
    n = len(t)
    if n <= points:
        return t, x
    stretch = -(-n // (points // 2))
    whole = n // stretch * stretch
    parts = x[:whole].reshape(-1, stretch)
    start = np.arange(0, whole, stretch)
    kept = np.sort(
        np.column_stack([start + parts.argmin(axis=1), start + parts.argmax(axis=1)]), axis=1
    ).ravel()
    if whole < n:
        rest = x[whole:]
        ends = {whole + int(rest.argmin()), whole + int(rest.argmax())}
        kept = np.concatenate([kept, np.array(sorted(ends))])
    return t[kept], x[kept]
