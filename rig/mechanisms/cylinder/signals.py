"""The pair's log as its diagnosis takes it."""

from typing import TYPE_CHECKING

import numpy as np

from rig.mechanisms.cylinder.watch import CHANNELS
from rig.mechanisms.pneumatic.diagnosis.evidence import Signals
from rig.mechanisms.pneumatic.hindsight import stacked

if TYPE_CHECKING:
    from rig.hal.hindsight import Logged

PAIRS = ((0, 1),)


def pair_signals(logged: "Logged") -> Signals:
    """Return what a log says of the pair."""
    pressures = stacked(logged, "reading.pressure_", CHANNELS)
    return Signals(
        logged("clock"),
        stacked(logged, "applied.", CHANNELS),
        pressures,
        stacked(logged, "reading.position_", CHANNELS),
        np.zeros((len(pressures), len(PAIRS))),
    )
