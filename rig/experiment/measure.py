"""What a measure is given: the followed part of a log, cut into windows.

Every measure is a pure function of windows, one per segment.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.hal.motion import Segment
from rig.runtime.log import LogError
from rig.runtime.log_columns import LogColumns

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

PHASE_RUN = 1.0
"""Value of the log's column ``phase`` while the reference is followed."""
SLOPE_SPAN = 0.02
"""Length of the straight line that a velocity is taken from, s. With an encoder of 1 µm read at
500 Hz its noise is 14 µm/s; a 20 Hz limit cycle keeps 80 % of its amplitude."""

_WINDOWS_AT_ONCE = 10_000


class Samples:
    """The part of a log in which the reference was followed.

    Parameters
    ----------
    log : LogColumns
        With the columns ``phase`` and ``reference.time``.
    constants : mapping of str to float
        What is known of the rig, SI; see `rig.hal.Mechanism.constants_of`.

    Raises
    ------
    LogError
        It lacks one of the two columns.
    """

    def __init__(
        self, log: LogColumns, constants: Mapping[str, float] = MappingProxyType({})
    ) -> None:
        self._log = log
        self._constants = constants
        self._run = stretch_of(log.column("phase") == PHASE_RUN)
        self._slope: tuple[str, Array] | None = None
        self.t = self.column("reference.time")
        self.period = float(np.median(np.diff(self.t))) if len(self.t) > 1 else 0.0

    @property
    def log(self) -> LogColumns:
        """The whole log."""
        return self._log

    def constant(self, name: str) -> float:
        """Return a number that is known of the rig, SI; LogError if it is not."""
        try:
            return self._constants[name]
        except KeyError:
            raise LogError(f"the run does not say what {name} the rig has") from None

    def controlled(self, name: str, energised: float) -> "Array":
        """Return a column of every cycle that was controlled, shape (n,).

        Parameters
        ----------
        name : str
            Of the column.
        energised : float
            When control took over, s since the first cycle: the approach begins.
        """
        since = self._log.column("reference.time")
        part = (since - since[:1] >= energised) & (self._log.column("phase") <= PHASE_RUN)
        values: Array = self._log.column(name)[part]
        return values

    def recorded(self, name: str) -> "Array":
        """Return a column of every cycle, energising and release included, shape (n,)."""
        values: Array = self._log.column(name)
        return values

    def column(self, name: str) -> "Array":
        """Return one column, shape (n,); LogError if there is none."""
        return np.asanyarray(self._log.column(name)[self._run], order="C")

    def slope(self, name: str) -> "Array":
        """Return a column's derivative, shape (n,); see `local_slope`. The last one is kept."""
        if self._slope is None or self._slope[0] != name:
            self._slope = name, local_slope(self.t, self.column(name))
        return self._slope[1]

    def names(self, prefix: str) -> tuple[str, ...]:
        """Return the columns that start with `prefix`."""
        return self._log.names(prefix)


_TRUTH = "truth."


class NoSuchMotion(ValueError):
    """No segment has the motion of a measure: without a bound its metric is left out."""


class NoTruth(Exception):
    """A measure takes the true state, which only a simulation in the same process records."""


class Window:
    """The samples of one segment.

    Parameters
    ----------
    segment : Segment
        Which.
    samples : Samples
        Everything that was followed.
    part : slice
        Where in it the segment lies.
    """

    def __init__(self, segment: Segment, samples: Samples, part: slice) -> None:
        self.segment = segment
        self._samples = samples
        self._part = part

    @property
    def samples(self) -> Samples:
        """Everything that was recorded."""
        return self._samples

    @property
    def t(self) -> "Array":
        """Seconds since the reference started, shape (n,)."""
        t: Array = self._samples.t[self._part]
        return t

    def column(self, name: str) -> "Array":
        """Return one column of the log, SI, shape (n,); LogError or NoTruth if there is none."""
        if name.startswith(_TRUTH) and not self._samples.names(_TRUTH):
            raise NoTruth(name)
        return self._samples.column(name)[self._part]

    def before(self, name: str) -> float | None:
        """Return a column's value just before the window; None where nothing was followed yet."""
        last = self._part.start - 1
        return None if last < 0 else float(self._samples.column(name)[last])

    def has(self, name: str) -> bool:
        """Return whether the log has a column."""
        return name in self._samples.names(name)

    def columns(self, prefix: str) -> "Array":
        """Return all columns that start with `prefix`, shape (n, k).

        Raises
        ------
        LogError, NoTruth
            There is none.
        """
        names = self._samples.names(prefix)
        if not names and prefix.startswith(_TRUTH) and not self._samples.names(_TRUTH):
            raise NoTruth(prefix)
        if not names:
            raise LogError(f"the log has no columns {prefix}…")
        return np.column_stack([self.column(name) for name in names])

    def slope(self, name: str) -> "Array":
        """Return the derivative of a column, its unit per second, shape (n,)."""
        return self._samples.slope(name)[self._part]

    def error(self, quantity: str) -> "Array":
        """Return reference minus reading of a quantity, shape (n,)."""
        return self.column(f"reference.{quantity}") - self.column(f"reading.{quantity}")

    def joined(self, other: "Window") -> "Window | None":
        """Return both as one; None if the other one begins after this one has ended."""
        if other._part.start > self._part.stop:
            return None
        whole = slice(self._part.start, max(self._part.stop, other._part.stop))
        return Window(self.segment, self._samples, whole)


Windows = Sequence[Window]
Values = Callable[[Window], "Array"]
"""What a measure takes of a window, of any shape."""


def stretch_of(chosen: "NDArray[np.bool_]") -> "slice | NDArray[np.bool_]":
    """Return the slice that chosen cycles are, which takes no memory; themselves if it is none."""
    places = np.flatnonzero(chosen)
    if not len(places):
        return slice(0, 0)
    first, last = int(places[0]), int(places[-1]) + 1
    return slice(first, last) if last - first == len(places) else chosen


class Measure(NamedTuple):
    """A measure by its name.

    Parameters
    ----------
    compute : callable
        Takes the windows, returns the number in SI. Infinite when what it times never happens.
    unit : str
        SI unit, empty for a ratio.
    description : str
        For reports.

    Notes
    -----
    `compute` raises ValueError when the windows do not hold what it needs, and LogError when
    the log does not.
    """

    compute: Callable[[Windows], float]
    unit: str
    description: str


def apart(windows: Windows) -> list[Window]:
    """Return windows that hold each instant of the given ones once: amounts may be added up."""
    found: list[Window] = []
    for window in sorted(windows, key=lambda window: window.segment.start):
        whole = found[-1].joined(window) if found else None
        if whole is None:
            found.append(window)
        else:
            found[-1] = whole
    return found


def rms(values: "Array") -> float:
    """Return the root of the mean square."""
    return math.sqrt(float(np.mean(values * values)))


def pooled(windows: Windows, values: Values) -> "Array":
    """Return the values of all windows, one after the other."""
    return np.concatenate([values(window) for window in windows])


def lengths(vectors: "Array") -> "Array":
    """Return the length of each row, shape (n,)."""
    found: Array = np.linalg.norm(vectors, axis=1)
    return found


def greatest(values: Values) -> Callable[[Windows], float]:
    """Return what computes the greatest absolute value in any window."""
    return lambda windows: max(float(np.abs(values(window)).max()) for window in windows)


def rms_of(values: Values) -> Callable[[Windows], float]:
    """Return what computes the root of the mean square of the values in all windows."""
    return lambda windows: rms(pooled(windows, values))


def column(name: str) -> Values:
    """Return what takes one column of the log."""
    return lambda window: window.column(name)


def columns(prefix: str) -> Values:
    """Return what takes all columns of the log that start with `prefix`."""
    return lambda window: window.columns(prefix)


def local_slope(t: "Array", x: "Array") -> "Array":
    """Differentiate by straight lines fitted to `SLOPE_SPAN` around each sample.

    Parameters
    ----------
    t : ndarray
        s, increasing, not necessarily evenly spaced, shape (n,).
    x : ndarray
        Shape (n,).

    Returns
    -------
    ndarray
        Slopes, shape (n,); the first and last half span repeat the nearest whole fit.

    References
    ----------
    A. Savitzky, M. J. E. Golay, Anal. Chem. 36(8), 1964 (first order, uneven abscissae).
    """
    n = len(t)
    if n < 2:
        return np.zeros(n)
    half = max(1, round(0.5 * SLOPE_SPAN * (n - 1) / float(t[-1] - t[0])))
    width = min(2 * half + 1, n)
    found = np.empty_like(t, np.float64)
    before = (width - 1) // 2
    slopes = found[before : before + n - width + 1]
    # A piece at a time: every sample stands in `width` windows at once.
    for start in range(0, len(slopes), _WINDOWS_AT_ONCE):
        here = slice(start, start + _WINDOWS_AT_ONCE)
        times = np.lib.stride_tricks.sliding_window_view(t, width)[here]
        times = times - times.mean(axis=1, keepdims=True)
        values = np.lib.stride_tricks.sliding_window_view(x, width)[here]
        slopes[here] = (times * values).sum(axis=1) / (times * times).sum(axis=1)
    found[:before], found[before + len(slopes) :] = slopes[0], slopes[-1]
    return found
