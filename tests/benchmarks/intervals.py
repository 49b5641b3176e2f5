"""How sure a ratio of two costs is that were measured in turn."""

from collections.abc import Sequence

import numpy as np
from scipy.stats import bootstrap


def ratio_of(ours: Sequence[float], theirs: Sequence[float]) -> tuple[float, float, float]:
    """Return the median of the rounds' ratios, and where it lies in 95 of 100 resamplings.

    A round measures both, one after the other, so that whatever else the machine does then falls
    on both.
    """
    ratios = np.divide(ours, theirs)
    found = bootstrap((ratios,), np.median, n_resamples=2000, method="percentile")
    low, high = found.confidence_interval
    return float(np.median(ratios)), float(low), float(high)
