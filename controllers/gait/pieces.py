"""Rows of a long plan, a few thousand at a time: its links' places would fill a gigabyte."""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_AT_ONCE = 10_000


def pieces(count: int) -> Iterator[slice]:
    """Yield the rows of an array of so many, in their order; one piece at least."""
    for first in range(0, max(count, 1), _AT_ONCE):
        yield slice(first, min(first + _AT_ONCE, count))


def in_pieces(compute: Callable[..., Array], *rows: Array) -> Array:
    """Return what a function makes of arrays with as many rows, computed piece by piece."""
    made = [compute(*(its[piece] for its in rows)) for piece in pieces(len(rows[0]))]
    return np.concatenate(made)
