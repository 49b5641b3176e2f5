"""Numbers that say how late the joint's camera is, and how well that is known.

A driver stamps each sample with the middle of its exposure: the time at which the frame arrived,
less the latency that was calibrated. If that is wrong, the samples lie beside the marker's track
by the error times the marker's velocity. Against the encoders the error can be told on any rig,
but only as far as they know the marker: friction of the wires on the ball turns round with the
velocity and looks like a delay. Against the plant's true marker it can be told in simulation.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.experiment.measures.base import Measure, Window, Windows, local_slope

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ENCODERS, TRUTH = "estimate.encoder_marker", "truth.marker"
_SAME = 1e-6
"""Two stamps that differ by less are of one sample, s."""
_FEWEST = 10
"""Fewer samples than these tell nothing."""


class Samples(NamedTuple):
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


def camera_samples(window: Window) -> Samples:
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
    return Samples(stamps[fresh], age[fresh], marker)


def stamp_error(windows: Windows, source: str) -> float:
    """Return by how much the stamps are too late, s: the exposure was so much earlier.

    Parameters
    ----------
    windows : sequence of Window
        In which the marker moves.
    source : str
        Columns of what the samples are held against, without the axis.
    """
    products = squares = 0.0
    for window in windows:
        samples = camera_samples(window)
        inside = samples.t >= window.t[0]
        for number, axis in enumerate("xyz"):
            track = window.column(f"{source}_{axis}")
            speed = np.interp(samples.t, window.t, local_slope(window.t, track))[inside]
            gap = samples.marker[inside, number] - np.interp(samples.t, window.t, track)[inside]
            gap -= gap.mean()
            products -= float(gap @ speed)
            squares += float(speed @ speed)
    if squares == 0.0:
        raise ValueError("the marker does not move")
    return products / squares


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
