"""Least and greatest value of each stretch of a log: a long run on few pixels, no spike lost."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

CAPACITY = 16384
"""Stretches that are kept. When they are full, two become one: memory does not grow."""
_FIRST_STRETCH = 16


class Extremes:
    """The least and the greatest value of every column in stretches of equally many rows.

    Parameters
    ----------
    columns : int
        k, values of a row.
    capacity : int
        Stretches that are kept at most; even.

    Attributes
    ----------
    stretch : int
        Rows of one stretch; it doubles when there are too many of them.
    count : int
        Rows that were added.
    """

    def __init__(self, columns: int, capacity: int = CAPACITY) -> None:
        self.stretch = _FIRST_STRETCH
        self.count = 0
        self._capacity = capacity
        self._start = np.zeros(capacity)
        self._least = np.full((capacity, columns), np.nan, np.float32)
        self._most = np.full((capacity, columns), np.nan, np.float32)

    def add(self, t: "NDArray[np.float64]", values: "NDArray[np.float64]") -> None:
        """Take further rows: their times (n,), s, and values, shape (n, k)."""
        done = 0
        while done < len(t):
            if self.count == self._capacity * self.stretch:
                self._halve()
            room = self._capacity * self.stretch - self.count
            piece = slice(done, done + min(room, len(t) - done))
            self._take(t[piece], values[piece].astype(np.float32))
            done = piece.stop

    def between(
        self, first: int, last: int, columns: "NDArray[np.intp]", most: int
    ) -> "tuple[NDArray[np.float64], NDArray[np.float32]]":
        """Return the extremes of the stretches that rows `first` to `last` lie in.

        Parameters
        ----------
        first, last : int
            From the first one up to but without the last one.
        columns : ndarray of int
            Which columns, (c,).
        most : int
            So many rows are returned at most, about.

        Returns
        -------
        t : ndarray, shape (m,)
            s.
        values : ndarray, shape (m, c)
            By turns the least and the greatest values of a stretch.
        """
        begin, end = first // self.stretch, -(-min(last, self.count) // self.stretch)
        count = max(end - begin, 0)
        together = max(-(-2 * count // max(most, 2)), 1)
        starts = np.arange(begin, begin + count, together)
        if not len(starts):
            return np.empty(0), np.empty((0, len(columns)), np.float32)
        offsets = starts - begin
        least = np.fmin.reduceat(self._least[begin:end, columns], offsets)
        greatest = np.fmax.reduceat(self._most[begin:end, columns], offsets)
        return _by_turns(self._start[starts], least, greatest)

    def _take(self, t: "NDArray[np.float64]", values: "NDArray[np.float32]") -> None:
        """Take rows for which there is room."""
        number = (self.count + np.arange(len(t))) // self.stretch
        offsets = np.flatnonzero(np.diff(number, prepend=number[0] - 1))
        places = number[offsets]
        begun = self.count % self.stretch > 0
        self._start[places[begun:]] = t[offsets[begun:]]
        self._least[places] = np.fmin(self._least[places], np.fmin.reduceat(values, offsets))
        self._most[places] = np.fmax(self._most[places], np.fmax.reduceat(values, offsets))
        self.count += len(t)

    def _halve(self) -> None:
        """Make one stretch of two."""
        half = self._capacity // 2
        self._start[:half] = self._start[::2].copy()
        self._least[:half] = np.fmin(self._least[::2], self._least[1::2])
        self._most[:half] = np.fmax(self._most[::2], self._most[1::2])
        self._least[half:] = self._most[half:] = np.nan
        self.stretch *= 2


def stretch_for(rows: int, most: int) -> int:
    """Return how many rows become two, so that no more than `most` come of them."""
    return -(-2 * rows // max(most, 2))


def reduce_by(
    t: "NDArray[np.float64]", values: "NDArray[np.float32]", stretch: int
) -> "tuple[NDArray[np.float64], NDArray[np.float32]]":
    """Return the extremes of stretches of so many rows.

    Parameters
    ----------
    t : ndarray, shape (n,)
        s.
    values : ndarray, shape (n, c)
        Of these times.
    stretch : int
        Rows that become two.
    """
    offsets = np.arange(0, len(t), stretch)
    least = np.fmin.reduceat(values, offsets)
    return _by_turns(t[offsets], least, np.fmax.reduceat(values, offsets))


def _by_turns(
    start: "NDArray[np.float64]", least: "NDArray[np.float32]", greatest: "NDArray[np.float32]"
) -> "tuple[NDArray[np.float64], NDArray[np.float32]]":
    return np.repeat(start, 2), np.stack([least, greatest], axis=1).reshape(-1, least.shape[1])
