"""Rods' extension while the pull of their chambers grows and falls: wires, and seals on the way.

A wire of stiffness k gives by what reaches it of the pull P of its chamber, so that a rod stands
out by

    x = home - (P - F) / k,

F being what the seals keep from the wire, which depends on where the rod has come from. Before a
seal slides its bristles bend over (Dahl),

    dF / d(-x) = s (1 - F / g)  inwards,    s (1 + F / g)  outwards,    g = f_0 + f_1 P,

so F follows g, which grows with the pressure, late on both ways, and after a turn it only comes
near it. In terms of the pull, which is what is known all along the way, and with b = k / s,

    dF / dP = u / (b + u),    u = 1 - F / g  inwards,    1 + F / g  outwards.

Home, k, f_0, f_1 and b are one fit: the steps right after a turn tell b. What a level's mean errs
by is what the encoders' steps round off, which differs from level to level, since the sweeps are
shifted against each other: levels err independently. Whether they do is looked at: of a rig that
drifts or creeps whole sweeps would err together, and the intervals would be too narrow.

References
----------
P. R. Dahl, "A solid friction model", Aerospace Corp. TOR-158(3107-18), 1968.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from rig.calibration.arrays import Array
from rig.calibration.estimates import Fit, differ, fit

_SURE: Final = 0.999
"""That whole sweeps err together, before it is said."""

_STRIDE: Final = 0.6
"""Pull between two steps of the integration, N: bristles bend over in some five."""


class Level(NamedTuple):
    """One step of a sweep.

    Parameters
    ----------
    sweep : int
        Its number.
    side : int
        +1 on the way up, -1 on the way down, 0 where it turns or only passes.
    pull : float
        Of a chamber, N.
    extension : float
        Of the rods, m; NaN where they are only on their way.
    """

    sweep: int
    side: int
    pull: float
    extension: float


class WireFit(NamedTuple):
    """A fit of all levels.

    Parameters
    ----------
    found : Fit
        Home (mm), 1/k (mm/N), f_0 (N), f_1 (1) and b (1); residuals in mm.
    fitted : ndarray, shape (n,)
        Extension that this makes of each level, m.
    steady : bool
        Whether the sweeps err by no more than their levels explain.
    """

    found: Fit
    fitted: Array
    steady: bool


def friction_along(pulls: Sequence[float], dry: float, growth: float, bend: float) -> list[float]:
    """Return what the seals keep from a wire at each pull, N.

    Parameters
    ----------
    pulls : sequence of float
        In the order in which they come, N; the seals slide outwards at the first.
    dry, growth : float
        Friction without a pull, N, and by how much it grows with it.
    bend : float
        Stiffness of the wire over that of the bristles.
    """
    pull = pulls[0]
    friction = -(dry + growth * pull)
    kept = [friction]
    for goal in pulls[1:]:
        count = int(abs(goal - pull) / _STRIDE) + 1
        step = (goal - pull) / count
        side = 1.0 if step > 0.0 else -1.0
        for _ in range(count):
            first = 1.0 - side * friction / (dry + growth * pull)
            half = friction + 0.5 * step * first / (bend + first)
            middle = 1.0 - side * half / (dry + growth * (pull + 0.5 * step))
            friction += step * middle / (bend + middle)
            pull += step
        kept.append(friction)
    return kept


def fit_wires(levels: Sequence[Level]) -> WireFit:
    """Fit all sweeps, each of which starts where the last step outwards ends.

    Raises
    ------
    ValueError
        The levels do not determine every parameter.
    """
    numbers = sorted({level.sweep for level in levels})
    paths = [[level.pull for level in levels if level.sweep == number] for number in numbers]
    seen = np.array([not np.isnan(level.extension) for level in levels])
    pull, extension = (
        np.array([level[k] for level in levels])[seen] * unit for k, unit in ((2, 1.0), (3, 1e3))
    )
    sweep, side = (np.array([float(level[k]) for level in levels])[seen] for k in (0, 1))

    def modelled(q: Array) -> Array:
        dry, growth, bend = float(q[2]), float(q[3]), abs(float(q[4])) + 1e-6
        kept = [f for path in paths for f in friction_along(path, dry, growth, bend)]
        return np.asarray(q[0] - q[1] * (pull - np.array(kept)[seen]))

    # Far from the turns both ways are nearly straight.
    lines = np.column_stack([np.ones_like(pull), -pull, side, side * pull])[side != 0.0]
    home, give, up, rise = np.linalg.lstsq(lines, extension[side != 0.0], rcond=None)[0]
    found = fit(
        lambda q: extension - modelled(q),
        (home, give, up / give, rise / give, 0.5), (1.0, 0.01, 1.0, 0.01, 0.1),
    )  # fmt: skip
    steady = not differ(found.residuals, 2.0 * sweep + (side > 0.0), _SURE)
    return WireFit(found, 1e-3 * modelled(found.values), steady)
