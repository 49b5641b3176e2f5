"""One number for gains on an ensemble: accuracy where they are quiet, and what they overstep."""

import math
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from rig.hal.bench import Trial
from rig.hal.closed_loop import SENSITIVITY, ClosedLoop

REVERSALS: Final = 25.0
"""So often may a setpoint turn round by 25 kPa, 1/s: a valve's life is counted in them."""
STRAYED: Final = 0.8
"""More than this share of the error that stops a rig is too much on any plant."""
QUIET: Final = 0.1e-3
"""More motion than this in a hold is hunting, SI …"""
HUNTING: Final = 0.3e-3
"""… and more than this, SI, is worse than a cost: no run that hunts so is well."""
_FINEST: Final = 1e-6
"""Errors below this are none, SI."""
LOST: Final = 1000.0
"""Cost of gains that lose a plant, and more the earlier they do."""
STOPPED: Final = 1.0
"""Cost of each plant that the program would be stopped on, or that hunts for good."""
REFUSED: Final = 1500.0
"""Cost of gains that hardware is refused with, and more the nearer they are to instability."""
UNSTABLE: Final = 2000.0
"""Cost of gains that are not stable, and more the farther they are from it."""
_WORST: Final = 0.5
"""Weight of the worst plant beside the nominal one."""
_PER_SENSITIVITY: Final = 20.0
"""Weight of the logarithm of the greatest sensitivity over its bound: a hundredth of it is as dear
as a tenth of all errors. Where no gains keep it, not all errors are given for it.
"""
_BEYOND: Final = 3.0
"""Cost of a sensitivity that is beyond its bound by as much as drawn plants scatter: without it
errors that are a third less would buy gains of which two plants in three have too little margin.
"""
_SCATTER: Final = 0.05
"""Of the greatest sensitivity on drawn plants, as a share: it costs so much in proportion."""
NEAREST: Final = 9.0
"""More sensitivity than this costs no more."""
_PER_REVERSAL: Final = 1.0 / REVERSALS


class Score(NamedTuple):
    """The worth of gains; less is better.

    Parameters
    ----------
    cost : float
        Mean logarithm of the nominal and of the worst errors, and what is overstepped.
    errors : float
        Its first part.
    """

    cost: float
    errors: float


def score(trials: Sequence[Trial], margins: Sequence[ClosedLoop]) -> Score:
    """Judge gains by their trials, the nominal plant's first, and by their margins.

    The errors of slow and fast motions count by their ratios: no unit and no rig's size is in it.
    """
    if any(trial.lasted < 1.0 for trial in trials):
        return Score(LOST, math.inf)
    if not all(margin.stable for margin in margins):
        return Score(UNSTABLE, math.inf)
    nominal = trials[0].errors
    worst = {name: max(trial.errors[name] for trial in trials) for name in nominal}
    errors = _mean_log(nominal.values()) + _WORST * _mean_log(worst.values())
    over = [max(0.0, trial.reversals - REVERSALS) * _PER_REVERSAL for trial in trials]
    hunts = [max(0.0, math.log(max(trial.hunting, _FINEST) / QUIET)) for trial in trials]
    near = max((min(margin.sensitivity, NEAREST) for margin in margins), default=SENSITIVITY)
    beyond = max(0.0, math.log(near / SENSITIVITY))
    nearness = _BEYOND * min(1.0, beyond / _SCATTER) + _PER_SENSITIVITY * beyond
    strays = [max(0.0, trial.strayed - STRAYED) for trial in trials]
    overstepped = (sum(over) + sum(hunts)) / len(trials) + sum(strays)
    worst_of_all = max(over) + _WORST * max(hunts) + max(strays)
    return Score(errors + overstepped + worst_of_all + nearness, errors)


def _mean_log(errors: Iterable[float]) -> float:
    logs = [math.log(max(error, _FINEST) / 1e-3) for error in errors]
    return sum(logs) / len(logs)
