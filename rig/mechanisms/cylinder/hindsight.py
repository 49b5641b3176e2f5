"""The pair's log as its diagnosis takes it."""

from typing import TYPE_CHECKING

import numpy as np

from rig.hal.hindsight import Suspect
from rig.mechanisms.cylinder.settings import CylinderSettings
from rig.mechanisms.cylinder.watch import CHANNELS
from rig.mechanisms.pneumatic.diagnosis.evidence import Signals
from rig.mechanisms.pneumatic.hindsight import stacked, suspects

if TYPE_CHECKING:
    from rig.hal.hindsight import Logged

_PAIRS = ((0, 1),)


def pair_suspects(logged: "Logged", settings: CylinderSettings) -> tuple[Suspect, ...]:
    """Return what explains the end of the pair's log best."""
    pressures = stacked(logged, "reading.pressure_", CHANNELS)
    none = np.zeros((len(pressures), len(_PAIRS)))
    signals = Signals(
        logged("clock"),
        stacked(logged, "applied.", CHANNELS),
        pressures,
        stacked(logged, "reading.position_", CHANNELS),
        none,
        none,
    )
    return suspects(signals, CHANNELS, _PAIRS, settings)
