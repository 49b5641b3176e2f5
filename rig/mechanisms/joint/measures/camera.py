"""Numbers that say how late the joint's camera is, and how well that is known.

A driver stamps each sample with the middle of its exposure: the time at which the frame arrived,
less the latency that was calibrated. If that is wrong, the samples lie beside the marker's track
by the error times the marker's velocity. Against the encoders the error can be told on any rig,
but only as far as they know the marker: friction of the wires on the ball turns round with the
velocity and looks like a delay. Against the plant's true marker it can be told in simulation.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.experiment.measure import Measure, Window, Windows, local_slope

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ENCODERS, TRUTH = "estimate.encoder_marker", "truth.marker"
_SAME = 1e-6
"""Two stamps that differ by less are of one sample, s."""
_ROUNDS = 4
"""Each corrects what the one before has left; the first one is linear."""
_FEWEST = 10
"""Fewer samples than these tell nothing."""


class CameraSamples(NamedTuple):
    """The samples of a camera that arrived within a window.

    Parameters
    ----------
    t : ndarray
        Stamps, s of reference time, shape (n,).
    age : ndarray
        When each was used first, s, shape (n,).
    marker : ndarray
        m, shape (n, 3).
    """

    t: "Array"
    age: "Array"
    marker: "Array"


def camera_samples(window: Window) -> CameraSamples:
    """Return each sample of a window once.

    Raises
    ------
    ValueError
        There are too few to tell anything.
    """
    age = window.column("reading.marker_age")
    stamps = window.t - age
    fresh = np.flatnonzero((np.diff(stamps, prepend=stamps[:1]) > _SAME) & (age >= 0.0))
    if len(fresh) < _FEWEST:
        raise ValueError(f"the camera gave only {len(fresh)} samples")
    marker = np.column_stack([window.column(f"reading.marker_{axis}")[fresh] for axis in "xyz"])
    return CameraSamples(stamps[fresh], age[fresh], marker)


def stamp_error(windows: Windows, source: str) -> float:
    """Return by how much the stamps are too late, s: the exposure was so much earlier.

    Parameters
    ----------
    windows : sequence of Window
        In which the marker moves.
    source : str
        Columns of what the samples are held against, without the axis.
    """
    error = 0.0
    tracks = [_Track(window, source) for window in windows]
    for _ in range(_ROUNDS):
        products = squares = 0.0
        for track in tracks:
            gap, speed = track.misfit(error)
            products -= float(np.sum(gap * speed))
            squares += float(np.sum(speed * speed))
        if squares == 0.0:
            raise ValueError("the marker does not move")
        error += products / squares
    return error


class _Track:
    """The marker's way through a window, and what the camera saw of it.

    Parameters
    ----------
    window : Window
        In which it moves.
    source : str
        Columns of the way, without the axis.
    """

    def __init__(self, window: Window, source: str) -> None:
        self._t = window.t
        self._samples = camera_samples(window)
        self._way = np.column_stack([window.column(f"{source}_{axis}") for axis in "xyz"])
        self._speed = np.column_stack([local_slope(window.t, way) for way in self._way.T])

    def misfit(self, late: float) -> "tuple[Array, Array]":
        """Return by how far the samples are beside the way, m, and its speed there, m/s.

        `late` (s) is by how much the stamps are taken to be too late; a constant distance, which
        is one of calibration, is left out.
        """
        t = self._samples.t - late
        inside = (t >= self._t[0]) & (t <= self._t[-1])
        t = t[inside]
        there, speed = (
            np.column_stack([np.interp(t, self._t, values) for values in signal.T])
            for signal in (self._way, self._speed)
        )
        gap = self._samples.marker[inside] - there
        return gap - gap.mean(axis=0), speed


def camera_latency(windows: Windows) -> float:
    """Return the mean age of a sample when it is used first, s."""
    return float(np.mean(np.concatenate([camera_samples(window).age for window in windows])))


def camera_latency_found(windows: Windows) -> float:
    """Return by how much the latency is longer than calibrated, as the encoders say, s."""
    return stamp_error(windows, ENCODERS)


def camera_latency_error(windows: Windows) -> float:
    """Return by how much the encoders misjudge the latency, s; only a simulation knows it."""
    return abs(stamp_error(windows, ENCODERS) - stamp_error(windows, TRUTH))


CAMERA_MEASURES: dict[str, Measure] = {
    "camera_latency": Measure(camera_latency, "s", "mean age of a sample when it is used first"),
    "camera_latency_found": Measure(
        camera_latency_found, "s", "latency beyond the calibrated one, by the encoders"
    ),
    "camera_latency_error": Measure(
        camera_latency_error, "s", "what the encoders misjudge the latency by"
    ),
}
