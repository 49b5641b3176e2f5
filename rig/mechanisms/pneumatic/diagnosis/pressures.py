"""Pressures that something holds, lets go or bounds, and monitors that say something else."""

import math
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from rig.mechanisms.pneumatic.diagnosis.causes import (
    Explanation,
    Scales,
    best_of_scan,
    best_since,
    share_gone,
)
from rig.mechanisms.pneumatic.diagnosis.evidence import LastSecond

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STUCK, OPEN, LEAK, SUPPLY, MONITOR = "stuck", "open", "leak", "supply", "monitor"

_TIMES: Final = np.array([2e-3, 8e-3, 25e-3, 80e-3])
"""In which a pressure goes to where a broken regulator leaves it, s."""
_SINKING: Final = (10e-3, 40e-3)
"""In which one sinks to what bounds it, s."""
_LEVELS: Final = 25
"""Pressures that are tried where one bounds others."""
_BEFORE: Final = 0.1
"""Setpoints of so long before count for where a pressure would have gone, s."""
_FAR: Final = 3.0
"""A pressure that goes by so many times what a healthy one may be off is not held."""
_POLYTROPIC: Final = 1.2
"""Of the air in a chamber that is shut."""
_ATMOSPHERE: Final = 101_325.0
"""Pa."""


def held_or_let_go(scales: Scales) -> list[Explanation]:
    """Return the best fit of each channel that does not follow, and of a supply that is too low."""
    evidence = scales.evidence
    found = [best_since(evidence, partial(_supply, scales))]
    for channel in range(len(evidence.names)):
        for fit in (_bounded, _shut, _monitor):
            found.append(best_since(evidence, partial(fit, scales, channel)))
        for cause in (STUCK, OPEN, LEAK):
            found.append(best_since(evidence, partial(_gone_to, scales, channel, cause)))
    return found


def _supply(scales: Scales, since: float, parameters: int) -> Explanation:
    """Return one level that no chamber gets beyond."""
    gains = [_gains_of_levels(scales, k, since) for k in range(len(scales.evidence.names))]
    levels, _ = gains[0]
    figure, gain = best_of_scan(levels, np.sum([found for _, found in gains], axis=0))
    return Explanation(SUPPLY, None, figure, gain - scales.price(parameters + 1))


def _bounded(scales: Scales, channel: int, since: float, parameters: int) -> Explanation:
    """Return a level that one chamber does not get beyond, for what it loses."""
    figure, gain = best_of_scan(*_gains_of_levels(scales, channel, since))
    return Explanation(LEAK, channel, figure, gain - scales.price(parameters + 1))


def _gains_of_levels(scales: Scales, channel: int, since: float) -> "tuple[Array, Array]":
    """Return levels, Pa gauge, and the gain of each of them as a bound of a pressure."""
    evidence, expected = scales.evidence, scales.expected[:, channel, None]
    levels = np.linspace(0.0, max(float(evidence.signals.setpoints.max()), 1.0), _LEVELS)
    over = np.maximum(expected - levels, 0.0)
    gains = [
        scales.gain(
            channel,
            scales.misfit(channel, expected - share_gone(evidence, since, time)[:, None] * over),
        )
        for time in _SINKING
    ]
    return levels, np.max(gains, axis=0)


def _gone_to(
    scales: Scales, channel: int, cause: str, since: float, parameters: int
) -> Explanation:
    """Return a pressure that goes to a level and stays there, if that is for this cause."""
    evidence = scales.evidence
    after = evidence.t >= since
    begun = float(scales.expected[int(np.argmax(after)), channel])
    before = np.where(after, begun, scales.expected[:, channel])
    shares = np.column_stack([share_gone(evidence, since, time) for time in _TIMES.tolist()])
    judged = shares[evidence.first :]
    off = (evidence.signals.pressures[:, channel] - before)[evidence.first :]
    squares = np.maximum(np.einsum("ij,ij->j", judged, judged), 1e-9)
    changes = off @ judged / squares
    gains = scales.gain(channel, scales.misfit(channel, before[:, None] + changes * shares))
    best = int(np.argmax(gains))
    change, gain = float(changes[best]), float(gains[best]) - scales.price(parameters + 1)
    if _why(evidence, channel, change, begun + change, since) != cause:
        gain = -math.inf
    return Explanation(cause, channel, begun + change, gain)


def _why(evidence: LastSecond, channel: int, change: float, level: float, since: float) -> str:
    """Return why a pressure goes to a level: away from its setpoints no stuck regulator goes."""
    asked = float(np.median(evidence.signals.setpoints[evidence.t >= since - _BEFORE, channel]))
    far = _FAR * evidence.static
    if change > far and level > asked:
        return OPEN
    return LEAK if change < -far and level < asked else STUCK


def _shut(scales: Scales, channel: int, since: float, parameters: int) -> Explanation:
    """Return a chamber that nothing enters or leaves: its piston alone changes its pressure."""
    evidence = scales.evidence
    settings, after = evidence.settings, evidence.t >= since
    way = settings.stroke - evidence.signals.extensions[:, channel]
    volume = settings.dead_volume + settings.area * way
    start = int(np.argmax(after))
    begun = float(scales.expected[start, channel]) + _ATMOSPHERE
    shut = begun * (volume[start] / volume) ** _POLYTROPIC - _ATMOSPHERE
    left = scales.misfit(channel, np.where(after, shut, scales.expected[:, channel])[:, None])
    gain = float(scales.gain(channel, left)[0]) - scales.price(parameters + 1)
    return Explanation(STUCK, channel, begun - _ATMOSPHERE, gain)


def _monitor(scales: Scales, channel: int, since: float, parameters: int) -> Explanation:
    """Return a monitor that says too much or too little."""
    evidence = scales.evidence
    off = (evidence.signals.pressures - scales.expected)[evidence.first :, channel]
    after = evidence.t >= since
    judged = after[evidence.first :]
    before = float(off[~judged].mean()) if not judged.all() else 0.0
    jump = float(off[judged].mean()) - before if judged.any() else 0.0
    left = scales.misfit(channel, (scales.expected[:, channel] + jump * after)[:, None])
    gain = float(scales.gain(channel, left)[0]) - scales.price(parameters + 1)
    return Explanation(MONITOR, channel, jump, gain)
