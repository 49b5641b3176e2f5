"""Regulators that answer slowly, or late."""

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from rig.mechanisms.pneumatic.diagnosis.answers import OtherRegulators, answer
from rig.mechanisms.pneumatic.diagnosis.causes import Explanation, Scales, best_of_scan

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SLOW, LATE = "slow", "late"

_SLOWEST: Final = 0.22
"""The least bandwidth that is tried, over the profile's …"""
_FROZEN: Final = 1.1 * _SLOWEST
"""… and below this one a regulator cannot be told from one that is stuck."""
_BANDWIDTHS: Final = np.geomspace(_SLOWEST, 4.0, 31)
"""Over the profile's: 10 % from one to the next."""
_LATE: Final = np.arange(-0.02, 0.0405, 2e-3)
"""Dead times beyond the profile's, s."""
_AGO: Final = np.geomspace(0.03, 0.9, 10)
"""How long before the end a regulator may have become slow, s."""
_SHARES: Final = np.geomspace(_SLOWEST, 0.85, 8)
"""Bandwidths that are tried for each of these instants."""
_PLAIN: Final = 3e-3
"""Dead times that differ by less than this are the same, s."""


def slow_or_late(scales: Scales) -> list[Explanation]:
    """Return regulators of another bandwidth, also since some time, or of more dead time.

    What a healthy one may be off by is left out. So is less dead time: what a profile says is that
    of its worst channel, and the others, which answer sooner, are well.
    """
    evidence = scales.evidence
    response, count = evidence.response, len(evidence.names)
    lates = _LATE[response.dead_time + _LATE >= 0.0]
    tried = [(share, -math.inf, 0.0) for share in _BANDWIDTHS.tolist()]
    tried += [(1.0, -math.inf, late) for late in lates.tolist()]
    gains = _gains(scales, np.tile(np.array(tried), (count, 1, 1)))
    bandwidths, dead_times = _BANDWIDTHS * response.bandwidth, lates + response.dead_time
    found = []
    for cause, axis, part in (
        (SLOW, bandwidths, gains[:, : len(_BANDWIDTHS)]),
        (LATE, dead_times, gains[:, len(_BANDWIDTHS) :]),
    ):
        for channel, row in ((None, part.sum(axis=0)), *enumerate(part)):
            figure, gain = best_of_scan(axis, row)
            found.append(Explanation(cause, channel, figure, gain - scales.price(1)))
    found += _became_slow(scales)
    spread = response.spread * response.bandwidth
    return [
        trial
        for trial in found
        if (
            trial.figure - response.dead_time > _PLAIN
            if trial.cause == LATE
            else abs(trial.figure - response.bandwidth) > spread
            and trial.figure > _FROZEN * response.bandwidth
        )
    ]


def _became_slow(scales: Scales) -> list[Explanation]:
    """Return, of each channel, a regulator that became slow within the last second."""
    evidence = scales.evidence
    count, end = len(evidence.names), float(evidence.t[-1])
    ago = _AGO[end - _AGO > evidence.t[0]]
    if not len(ago):
        return []
    shares, agos = (x.ravel() for x in np.meshgrid(_SHARES, ago))
    rough = np.column_stack([shares, end - agos, np.zeros(len(shares))])
    best = np.argmax(_gains(scales, np.tile(rough, (count, 1, 1))), axis=1)
    # Around the best of them once more, closer.
    ratios, steps = (_SHARES[1] / _SHARES[0], ago[1] / ago[0] if len(ago) > 1 else 1.0)
    near = np.linspace(-1.0, 1.0, 7)
    fine = np.empty((count, len(near) ** 2, 3))
    for k, centre in enumerate(best):
        some, back = (
            x.ravel()
            for x in np.meshgrid(shares[centre] * ratios**near, agos[centre] * steps**near)
        )
        fine[k] = np.column_stack([some, end - back, np.zeros(len(some))])
    gains = _gains(scales, fine)
    return [
        Explanation(
            SLOW,
            k,
            float(fine[k, int(np.argmax(row)), 0]) * evidence.response.bandwidth,
            float(row.max()) - scales.price(2),
        )
        for k, row in enumerate(gains)
    ]


def _gains(scales: Scales, tried: "Array") -> "Array":
    """Return the gains of regulators, shape (k, m).

    Parameters
    ----------
    scales : Scales
        The measure.
    tried : ndarray, shape (k, m, 3)
        Of each channel bandwidth over the profile's, since when, and dead time beyond its.
    """
    count, many, _ = tried.shape
    bandwidth, since, late = tried.reshape(-1, 3).T
    channel = np.repeat(np.arange(count), many)
    pressures = answer(scales.evidence, OtherRegulators(channel, bandwidth, since, late))
    left = scales.misfit(channel, pressures).reshape(count, many)
    return np.array([scales.gain(k, row) for k, row in enumerate(left)])
