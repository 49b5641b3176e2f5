"""The joint path of a motion that is there already: what its samples leave when time is gone."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from controllers.arm.axis_path import AxisPath
from controllers.arm.plan import Sample

Array = NDArray[np.float64]

_LAST = 0.3
"""Share of a period that the last one has at least."""


def timed_samples(
    motion: list[Sample], period: float, duration: float
) -> tuple[list[Sample], list[float]]:
    """Return the samples of a motion and their instants, s.

    Parameters
    ----------
    motion : list of Sample
        A period apart, but for the last, which is at rest at the end.
    period, duration : float
        s.

    Notes
    -----
    The one before the last is left out where it is so near to the end that it says nothing.
    """
    samples = list(motion)
    instants = [period * k for k in range(len(samples) - 1)]
    if len(samples) > 2 and duration - instants[-1] < _LAST * period:
        del samples[-2], instants[-1]
    return samples, [*instants, duration]


def axis_path_of_motion(
    samples: list[Sample], instants: list[float], share: float = 1.0
) -> AxisPath:
    """Return the joint path of a motion that may turn back, with the scales that it has.

    Parameters
    ----------
    samples : list of Sample
        The last at rest.
    instants : list of float
        Of each, s.
    share : float
        Of the commanded speed, with which it is done.
    """
    scales = [(sample.linear, sample.angular) for sample in samples[:-1]]
    scales.append(scales[-1])
    gone, turned = [0.0], [0.0]
    for (before, after), (a, b) in zip(pairwise(instants), pairwise(scales), strict=True):
        step = after - before
        gone.append(gone[-1] + 0.5 * share * step * (a[0] + b[0]))
        turned.append(turned[-1] + 0.5 * share * step * (a[1] + b[1]))
    return AxisPath([sample.positions for sample in samples], gone, turned)
