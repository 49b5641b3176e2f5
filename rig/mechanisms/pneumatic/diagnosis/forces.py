"""Forces of a pair that its pressures do not explain: other friction, or a chamber that pulls less.

Behind a tube a chamber may be empty while the monitor at the regulator shows pressure: only how the
rods move tells it.
"""

import math
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from rig.mechanisms.pneumatic.diagnosis.causes import Explanation, best_of_scan, best_since
from rig.mechanisms.pneumatic.diagnosis.evidence import LastSecond
from rig.mechanisms.pneumatic.settings import PneumaticSettings

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

FRICTION, PULL = "friction", "pull"

_FITTED: Final = 10e-3
"""Half of the time over which speed and acceleration are taken, s."""
_SCALES: Final = np.geomspace(0.25, 4.0, 33)
"""Friction over the profile's."""
_HEALTHY: Final = 0.35
"""Friction that differs by this share is that of a healthy pair."""
_PLAIN: Final = 0.3
"""Share of the breakaway force by which friction scatters."""
_INDEPENDENT: Final = 40.0
"""Samples a second that tell something of their own: stick and slip take as long."""


class PairForces(NamedTuple):
    """The forces on one pair in the last second.

    Parameters
    ----------
    channels : tuple of int
        Which pulls towards positive positions, and which towards negative ones.
    moved : ndarray, shape (n,)
        What the pressures leave to friction once the mass is accelerated, N.
    speed : ndarray, shape (n,)
        m/s.
    load : ndarray, shape (n,)
        Friction beside that of the seals, N.
    """

    channels: tuple[int, int]
    moved: "Array"
    speed: "Array"
    load: "Array"


def forces_of(evidence: LastSecond, pair: int) -> PairForces:
    """Return the forces on a pair, by its number."""
    signals, settings = evidence.signals, evidence.settings
    one, other = evidence.pairs[pair]
    position = 0.5 * (signals.extensions[:, other] - signals.extensions[:, one])
    step = float(np.median(np.diff(evidence.t)))
    half = max(2, round(_FITTED / step))
    k = np.arange(-half, half + 1)
    bend = k**2 - np.mean(k**2)
    padded = np.pad(position, half, mode="edge")
    speed = np.convolve(padded, k[::-1] / float((k**2).sum()), "valid") / step
    acceleration = np.convolve(padded, bend / float((bend**2).sum()), "valid") * 2.0 / step**2
    pull = settings.area * (signals.pressures[:, one] - signals.pressures[:, other])
    moved = pull + signals.falls[:, pair] - settings.moving_mass * acceleration
    return PairForces((one, other), moved, speed, signals.loads[:, pair])


def force_causes(evidence: LastSecond, pair: PairForces) -> list[Explanation]:
    """Return friction that is not the profile's, and a chamber that pulls less than it seems to."""
    settings = evidence.settings
    gain = partial(_gain, evidence, pair, settings)
    gains = np.array([gain(_left(pair, settings, scale)) for scale in _SCALES.tolist()])
    scale, best = best_of_scan(_SCALES, gains)
    price = math.log(_count(evidence))
    found = [best_since(evidence, partial(_pull, evidence, pair, settings))]
    if abs(scale - 1.0) > _HEALTHY:
        found.append(Explanation(FRICTION, min(pair.channels), scale, best - price))
    return found


def _pull(
    evidence: LastSecond,
    pair: PairForces,
    settings: PneumaticSettings,
    since: float,
    parameters: int,
) -> Explanation:
    """Return by how much less one of the two chambers pulls than its pressure says, Pa."""
    after = evidence.t >= since
    left = _left(pair, settings, 1.0)
    missing = float(left[after].mean())
    gain = _gain(evidence, pair, settings, left - missing * after)
    price = (parameters + 1) * math.log(_count(evidence))
    which = pair.channels[0 if missing > 0.0 else 1]
    return Explanation(PULL, which, abs(missing) / settings.area, gain - price)


def _left(pair: PairForces, settings: PneumaticSettings, scale: float) -> "Array":
    """Return what friction of that scale leaves of the forces, N, shape (n,)."""
    friction, speed, moved = settings.friction, pair.speed, pair.moved
    slides = np.abs(speed) > friction.stribeck_velocity
    force = np.sign(speed) * (friction.coulomb + pair.load) + friction.viscous * speed
    most = scale * (friction.breakaway + pair.load)
    found: Array = np.where(slides, moved - scale * force, moved - np.clip(moved, -most, most))
    return found


def _gain(
    evidence: LastSecond, pair: PairForces, settings: PneumaticSettings, left: "Array"
) -> float:
    judged = slice(evidence.first, None)
    noise = float(np.mean((_PLAIN * (settings.friction.breakaway + pair.load[judged])) ** 2))
    healthy = float(np.mean(_left(pair, settings, 1.0)[judged] ** 2))
    ratio = (healthy + noise) / (float(np.mean(left[judged] ** 2)) + noise)
    return _count(evidence) * math.log(ratio)


def _count(evidence: LastSecond) -> float:
    return max(_INDEPENDENT * float(evidence.t[-1] - evidence.t[evidence.first]), 2.0)
