"""The log of a pneumatic mechanism as its diagnosis takes it."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from rig.hal.hindsight import Suspect
from rig.mechanisms.pneumatic.diagnosis.causes import Explanation
from rig.mechanisms.pneumatic.diagnosis.evidence import LastSecond, Signals, gather
from rig.mechanisms.pneumatic.diagnosis.forces import FRICTION, PULL
from rig.mechanisms.pneumatic.diagnosis.held_back import held_back
from rig.mechanisms.pneumatic.diagnosis.ranking import likeliest, rank
from rig.mechanisms.pneumatic.diagnosis.words import suspect_of
from rig.mechanisms.pneumatic.settings import PneumaticSettings

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def stacked(logged: "Callable[[str], Array]", prefix: str, channels: Sequence[str]) -> "Array":
    """Return the columns of all channels, shape (n, k)."""
    return np.column_stack([logged(prefix + name) for name in channels])


def suspects(
    signals: Signals,
    channels: Sequence[str],
    pairs: tuple[tuple[int, int], ...],
    settings: PneumaticSettings,
    others: Callable[[LastSecond], list[Explanation]] = lambda _: [],
) -> tuple[Suspect, ...]:
    """Return what explains the end of a log best.

    Parameters
    ----------
    signals : Signals
        Of every cycle.
    channels : sequence of str
        Their names.
    pairs : tuple of tuple of int
        Agonist and antagonist of each pair.
    settings : PneumaticSettings
        Of the mechanism.
    others : callable
        Returns causes that are the mechanism's own.
    """
    known = np.all([np.isfinite(x).reshape(len(x), -1).all(axis=1) for x in signals], axis=0)
    evidence = gather(Signals(*(signal[known] for signal in signals)), channels, pairs, settings)
    if evidence is None:
        return ()
    fitted = [suspect_of(trial, evidence) for trial in likeliest(rank(evidence, others(evidence)))]
    # What is broken brings a law to its limits, too; that it pulls in vain looks like friction.
    broken = [suspect for suspect in fitted if suspect.cause not in (FRICTION, PULL)]
    vain = [suspect for suspect in fitted if suspect not in broken]
    return (*broken, *held_back(evidence), *vain)
