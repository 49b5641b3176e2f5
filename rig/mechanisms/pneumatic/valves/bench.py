"""What `rig tune` needs of a mechanism on proportional valves beside one on regulators."""

from collections.abc import Mapping, Sequence
from typing import Final

from rig.hal.plant import LentPlant
from rig.mechanisms.pneumatic.settings import PneumaticSettings
from rig.mechanisms.pneumatic.valves.lending import through_loops
from rig.mechanisms.pneumatic.valves.regulating import pressure_loops

_SPOOL_LAG: Final = 1.4
"""Twice the damping ratio of a spool, 0.7: over its bandwidth, by so much it is later."""


def on_regulators(
    lent: LentPlant,
    settings: PneumaticSettings,
    channels: Sequence[str],
    extensions: Sequence[float],
    period: float,
) -> LentPlant:
    """Return a plant that takes wanted pressures: as it is, or through the loops of its valves.

    Parameters
    ----------
    lent : LentPlant
        Vented and at home.
    settings : PneumaticSettings
        Of the mechanism.
    channels : sequence of str
        Its chambers.
    extensions : sequence of float
        Of their rods, m.
    period : float
        The loop's, s.
    """
    if settings.valves is None:
        return lent
    loops = pressure_loops(settings, channels, period)
    for loop, extension in zip(loops, extensions, strict=True):
        loop.reset(0.0, extension)
    return through_loops(lent, loops)


def spools_told(settings: PneumaticSettings) -> dict[str, float]:
    """Return what is believed of the spools, SI: nothing where there are none."""
    if settings.valves is None:
        return {}
    spool = settings.valves.spool
    return {"spool_bandwidth": spool.bandwidth, "spool_dead_time": spool.dead_time}


def dead_time_of(settings: PneumaticSettings, plant: Mapping[str, float]) -> float:
    """Return a plant's dead time as a linear model has it, s: later spools are dead time to it."""
    told = plant["regulator_dead_time"]
    if settings.valves is None:
        return told
    spool = settings.valves.spool
    late = plant["spool_dead_time"] - spool.dead_time
    late += _SPOOL_LAG * (1.0 / plant["spool_bandwidth"] - 1.0 / spool.bandwidth)
    return max(told + late, 0.0)
