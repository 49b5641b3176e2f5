"""Tell that an encoder's samples scatter: a law that differentiates them shakes its setpoints.

No regulator follows such setpoints, and all of them fall short as if the supply were lost.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

_FEW: Final = 16
"""Samples of which nothing is said yet."""
_LEAST: Final = 15e-6
"""m. E: three times what encoders scatter that laws are tuned for."""
_ALTERNATES: Final = -0.4
"""Correlation of a second difference with the next from which on down it is noise: -2/3 of white
noise, positive of what moves."""


def scatter(samples: Sequence[float]) -> float:
    """Return by how much equidistant samples scatter about a motion, standard deviation.

    0: they are too few, or what their second differences show is a motion.
    """
    if len(samples) < _FEW:
        return 0.0
    bends = [
        after - 2.0 * here + before
        for before, here, after in zip(samples, samples[1:], samples[2:], strict=False)
    ]
    power = math.fsum(bend * bend for bend in bends)
    follows = math.fsum(here * after for here, after in pairwise(bends))
    if not follows < _ALTERNATES * power:
        return 0.0
    return math.sqrt(power / len(bends) / 6.0)


def explain_scatter(encoders: Sequence[str], samples: Sequence[Sequence[float]]) -> str | None:
    """Return which encoder scatters most, if it is by more than laws are tuned for.

    Parameters
    ----------
    encoders : sequence of str
        Their names.
    samples : sequence of sequence of float
        Of every cycle, one of each encoder, m.
    """
    each = [scatter(its) for its in zip(*samples, strict=True)]
    most = max(each, default=0.0)
    if most < _LEAST:
        return None
    return f"{encoders[each.index(most)]} scatters by {most * 1e3:.2g} mm, which shakes setpoints"
