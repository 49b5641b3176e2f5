"""Long signals on few pixels, without losing a peak."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

POINTS = 3000
"""Greatest number of points of a drawn line: more than any print resolves at 170 mm."""
_SHORT_PATH = 100_000
"""A path in the plane of so many points is drawn as it is."""
_CELLS = 400
"""Of a longer one, along each axis: what a print resolves at 85 mm."""
_AT_ONCE = 1 << 16
"""Points of it that are looked at together."""


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


def path_envelope(
    x: "NDArray[np.float64]", y: "NDArray[np.float64]"
) -> "tuple[NDArray[np.float64], NDArray[np.float64]]":
    """Keep of a path in the plane where it comes to what it has not been at.

    One that goes round and round is drawn over itself: what it takes to draw does not grow with it.

    Parameters
    ----------
    x, y : ndarray
        Shape (n,).

    Returns
    -------
    x, y : ndarray
        Shape (m,); NaN where the line is to be broken. The path itself if it is short enough.
    """
    if len(x) <= _SHORT_PATH:
        return x, y
    axes = [(values, float(np.nanmin(values)), float(np.nanmax(values))) for values in (x, y)]
    been = np.zeros(_CELLS * _CELLS, bool)
    fresh = []
    for start in range(0, len(x), _AT_ONCE):
        part, cells = slice(start, start + _AT_ONCE), np.zeros(1, np.int64)
        for values, low, high in axes:
            share = np.nan_to_num((values[part] - low) / max(high - low, 1e-300))
            cells = _CELLS * cells + (share * (_CELLS - 1)).astype(np.int64)
        found, first = np.unique(cells, return_index=True)
        fresh.append(start + first[~been[found]])
        been[found] = True
    places = np.concatenate(fresh)
    # With the way there and on from there.
    kept = np.unique(np.concatenate([places - 1, places, places + 1]).clip(0, len(x) - 1))
    breaks = np.flatnonzero(np.diff(kept) > 1) + 1
    return np.insert(x[kept], breaks, np.nan), np.insert(y[kept], breaks, np.nan)
