"""Short names of the arrays that fits work on."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int_]
Flags: TypeAlias = NDArray[np.bool_]


def between_rows(rows: Array, places: Array | Indices, at: Array | Indices) -> Array:
    """Return a table's rows at other places, straight between those that it has.

    Parameters
    ----------
    rows : ndarray, shape (n, m)
        The table.
    places : ndarray, shape (n,)
        Where its rows are, rising.
    at : ndarray, shape (k,)
        Where they are wanted.

    Returns
    -------
    ndarray, shape (k, m)
    """
    return np.column_stack([np.interp(at, places, column) for column in rows.T])
