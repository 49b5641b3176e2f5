"""The interval of a sum of errors of different kinds: drawn from, not taken as normal altogether.

References
----------
JCGM 101:2008, "Propagation of distributions using a Monte Carlo method" (Supplement 1 to the
"Guide to the expression of uncertainty in measurement"): what is known to lie within bounds is
drawn evenly between them (6.4.2), what was found from few repetitions from Student's distribution
(6.4.9), and the interval is that of the drawn sums (7.7).
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from rig.calibration.estimates import CONFIDENCE, Estimate

_DRAWS: Final = 40_000
"""The interval's bounds are then right to about 1 %."""


def half_width(
    sampled: float, freedom: float, normal: float = 0.0, even: Sequence[float] = ()
) -> float:
    """Return half of the 95 % interval of a sum of independent errors, symmetric about 0.

    Parameters
    ----------
    sampled : float
        Standard deviation of what the data's scatter makes of it.
    freedom : float
        Degrees of freedom that this is known with.
    normal : float
        Standard deviation of all that is normal.
    even : sequence of float
        Standard deviation of each part that lies anywhere within its bounds, all equally likely.
    """
    random = np.random.default_rng(0)  # equal errors have equal intervals
    total = sampled * random.standard_t(freedom, _DRAWS)
    total += normal * random.standard_normal(_DRAWS)
    for part in even:
        if part:
            total += part * random.uniform(-np.sqrt(3.0), np.sqrt(3.0), _DRAWS)
    return float(np.quantile(np.abs(total), CONFIDENCE))


def estimate_of_sum(
    name: str,
    value: float,
    unit: str,
    sampled: float,
    freedom: float,
    normal: float = 0.0,
    even: Sequence[float] = (),
) -> Estimate:
    """Return an estimate whose error is a sum of independent ones; see `half_width`."""
    half = half_width(sampled, freedom, normal, even)
    std = math.hypot(sampled, normal, *even)
    return Estimate(name, value, unit, std, value - half, value + half)
